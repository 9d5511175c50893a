/* Runs one filter over samples made of whole numbers, and prints the last attitude and a hash over all of them, bit for bit:
 * `make firmware` compares the line with what Rust gives (firmware/examples/c_example.rs), on the host and on the microcontroller.
 *
 * Another filter is another name: cc -DFILTER=VQF. */

#include "ahrs_rs.h"

#ifndef FILTER
#define FILTER Madgwick
#endif
#ifndef UPDATES
#define UPDATES 10000
#endif

#define JOIN(a, b) a##b
#define TYPE(filter) JOIN(Ahrs, filter)
#define DESCRIPTION(filter) JOIN(ahrs_, filter)
#define TEXT(name) #name
#define NAME(filter) TEXT(filter)

/* From the C library on the host, from start.c on the microcontroller. */
int puts(const char *text);

static uint32_t noise = 12345;

/* A number of -1 to 1 that looks random: exact, as all that is computed here. */
static float uniform(void) {
    noise = noise * 1664525u + 1013904223u;
    return (float)((int32_t)noise >> 8) * (1.0f / 8388608.0f);
}

static uint64_t hash = 0xcbf29ce484222325u;

static uint32_t add(float number) {
    union {
        float number;
        uint32_t bits;
    } same = {number};
    for (int byte = 0; byte < 4; byte++) {
        hash ^= same.bits >> (8 * byte) & 255;
        hash *= 0x100000001b3u;
    }
    return same.bits;
}

static char *hexadecimal(char *at, uint64_t number, int digits) {
    *at++ = ' ';
    while (digits-- > 0) *at++ = "0123456789abcdef"[number >> (4 * digits) & 15];
    return at;
}

int main(void) {
    static TYPE(FILTER) ahrs;
    float quat[4];
    uint32_t bits[4];
    if (ahrs_init(&ahrs, sizeof ahrs, &DESCRIPTION(FILTER), NULL, 0, NULL) != AHRS_OK) return 1;
    for (int k = 0; k < UPDATES; k++) {
        /* It turns back and forth about a slanted axis, every 512 samples; the magnetometer has a quarter of the rate. */
        const float rate = (k & 512) ? -0.75f : 0.75f;
        const float gyr[3] = {rate, rate * 0.5f, uniform() * 0.25f};
        const float acc[3] = {uniform(), 2.0f, 9.5f};
        const float mag[3] = {uniform() * 2.0f, 20.0f, -43.0f};
        if (ahrs_update(&ahrs, gyr, acc, (k & 3) ? NULL : mag, 0.0078125f, quat) != AHRS_OK) return 1;
        for (int i = 0; i < 4; i++) bits[i] = add(quat[i]);
    }
    char line[128] = NAME(FILTER), *at = line;
    while (*at) at++;
    at = hexadecimal(at, hash, 16);
    for (int i = 0; i < 4; i++) at = hexadecimal(at, bits[i], 8);
    *at = 0;
    puts(line);
    return 0;
}
