#include <math.h>
#include <stdint.h>
#if defined(_WIN32)
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
int32_t wmr_probe(int32_t a) { return a + (int32_t)cosh(0.0 * a); }
