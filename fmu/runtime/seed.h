/* Seeds as numpy.random.SeedSequence reads them. */
#ifndef WMR_SEED_H
#define WMR_SEED_H

#include <stdint.h>

/* SeedSequence(seed).generate_state(2, uint64): the key of the noise for this seed. */
void wmr_seed_key(uint64_t seed, uint64_t key[2]);

#endif
