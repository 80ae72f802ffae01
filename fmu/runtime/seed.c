#include "seed.h"

#define POOL 4

/* Constants of M. E. O'Neill's seed_seq_fe, which NumPy uses. */
static const uint32_t INIT_A = 0x43b0d7e5u, MULT_A = 0x931e8875u;
static const uint32_t INIT_B = 0x8b51f9ddu, MULT_B = 0x58f38dedu;

static uint32_t hashed(uint32_t value, uint32_t *constant, uint32_t factor)
{
    value ^= *constant;
    *constant *= factor;
    value *= *constant;
    return value ^ (value >> 16);
}

static uint32_t mixed(uint32_t x, uint32_t y)
{
    const uint32_t value = 0xca01f9ddu * x - 0x4973f715u * y;
    return value ^ (value >> 16);
}

void wmr_seed_key(uint64_t seed, uint64_t key[2])
{
    uint32_t pool[POOL] = {(uint32_t)seed, (uint32_t)(seed >> 32), 0, 0};
    uint32_t constant = INIT_A, words[POOL];
    for (int i = 0; i < POOL; ++i) {
        pool[i] = hashed(pool[i], &constant, MULT_A);
    }
    for (int from = 0; from < POOL; ++from) {
        for (int to = 0; to < POOL; ++to) {
            if (from != to) {
                pool[to] = mixed(pool[to], hashed(pool[from], &constant, MULT_A));
            }
        }
    }
    constant = INIT_B;
    for (int i = 0; i < POOL; ++i) {
        words[i] = hashed(pool[i], &constant, MULT_B);
    }
    key[0] = words[0] | (uint64_t)words[1] << 32;
    key[1] = words[2] | (uint64_t)words[3] << 32;
}
