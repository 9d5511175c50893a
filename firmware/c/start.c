/* What a C program needs on the emulated board: vectors, start-up and semihosting, as src/target.rs has them for Rust. */

#include <stdint.h>

int main(void);
void reset(void);

extern uint32_t __data_start, __data_end, __data_load, __bss_start, __bss_end, __stack_start;

static int request(int operation, const void *block) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = block;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(uint32_t status) {
    const uint32_t block[2] = {0x20026, status};
    for (;;) request(0x20, block);
}

static void fault(void) { leave(70); }

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &__stack_start, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
    (void *)fault,  (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};

int puts(const char *text) {
    request(0x04, text);
    request(0x04, "\n");
    return 0;
}

void reset(void) {
    *(volatile uint32_t *)0xe000ed88 |= 0xf << 20; /* the floating-point unit on */
    __asm__ volatile("dsb\nisb");
    const uint32_t *from = &__data_load;
    for (uint32_t *to = &__data_start; to < &__data_end;) *to++ = *from++;
    for (uint32_t *to = &__bss_start; to < &__bss_end;) *to++ = 0;
    leave((uint32_t)main());
}
