/* A plugin of the emulator's code generator: counts the instructions that functions execute, callees included.
 *
 * Arguments: caller=START-END is where calls come from; name=ADDRESS is a function, up to eight; out=FILE gets a line
 * "name calls sum max" for each. A call begins with the block at the function's address and ends with the next block that lies
 * in the caller. Counted are instructions, not cycles; what a condition skips counts as executed. The emulator's packages
 * bring no header: declared here is what its documentation says of the few functions that are used. */

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
struct qemu_info;
void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, void (*)(plugin_id, struct qemu_plugin_tb *));
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *, void (*)(unsigned, void *), int flags, void *data);
void qemu_plugin_register_atexit_cb(plugin_id, void (*)(plugin_id, void *), void *data);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb *);

#ifndef PLUGIN_VERSION
#define PLUGIN_VERSION 1
#endif
__attribute__((visibility("default"))) int qemu_plugin_version = PLUGIN_VERSION;

struct function {
    char name[16];
    uint64_t address, calls, sum, max;
};

struct block {
    uint64_t instructions;
    struct function *begins;
    int in_caller;
};

static struct function functions[8];
static size_t function_count;
static uint64_t caller_start, caller_end;
static char out[4096];

/* The call under way, and its instructions so far. */
static struct function *running;
static uint64_t count;

static void executed(unsigned cpu, void *data) {
    const struct block *block = data;
    (void)cpu;
    if (running && block->in_caller) {
        running->calls += 1;
        running->sum += count;
        if (count > running->max) running->max = count;
        running = NULL;
    }
    if (block->begins) {
        running = block->begins;
        count = 0;
    }
    count += block->instructions;
}

static void translated(plugin_id id, struct qemu_plugin_tb *tb) {
    struct block *block = calloc(1, sizeof *block);
    uint64_t address = qemu_plugin_tb_vaddr(tb);
    (void)id;
    if (!block) abort();
    block->instructions = qemu_plugin_tb_n_insns(tb);
    block->in_caller = caller_start <= address && address < caller_end;
    for (size_t i = 0; i < function_count; i++)
        if (functions[i].address == address) block->begins = &functions[i];
    qemu_plugin_register_vcpu_tb_exec_cb(tb, executed, 0, block);
}

static void finished(plugin_id id, void *data) {
    FILE *file = fopen(out, "w");
    (void)id, (void)data;
    if (!file) abort();
    for (size_t i = 0; i < function_count; i++)
        fprintf(file, "%s %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", functions[i].name, functions[i].calls, functions[i].sum,
                functions[i].max);
    fclose(file);
}

__attribute__((visibility("default"))) int qemu_plugin_install(plugin_id id, const struct qemu_info *info, int argc,
                                                                char **argv) {
    (void)info;
    for (int i = 0; i < argc; i++) {
        char *value = strchr(argv[i], '=');
        if (!value) return 1;
        *value++ = 0;
        if (!strcmp(argv[i], "out")) {
            snprintf(out, sizeof out, "%s", value);
        } else if (!strcmp(argv[i], "caller")) {
            caller_start = strtoull(value, &value, 0);
            caller_end = strtoull(value + 1, NULL, 0);
        } else if (function_count < sizeof functions / sizeof *functions) {
            struct function *function = &functions[function_count++];
            snprintf(function->name, sizeof function->name, "%s", argv[i]);
            function->address = strtoull(value, NULL, 0);
        }
    }
    if (!*out) return 1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, finished, NULL);
    return 0;
}
