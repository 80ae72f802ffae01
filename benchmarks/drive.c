/* Loops that time a control step from C, the same for hand-written and for generated code: every
 * candidate is called through a pointer, from another library, over the same ring of input rows. */
#include <stdint.h>

typedef void step_function(const double *in, double *state, double *out);
typedef void kernel_function(const double *u, const double *x, const double *p, double *next,
                             double *y);

typedef void plant_function(const double *i, const double *u, const double *x, const double *p,
                            const double *w, double *next);

static double total(const double *values, int64_t count)
{
    double sum = 0.0;
    for (int64_t i = 0; i < count; i++)
        sum += values[i];
    return sum;
}

/* n calls of step over rows[count][width]; the sum of all outputs keeps every call alive. */
double drive(step_function *step, int64_t n, const double *rows, int64_t count, int64_t width,
             double *state, double *out, int64_t outputs)
{
    double sum = 0.0;
    for (int64_t i = 0, row = 0; i < n; i++) {
        step(rows + width * row, state, out);
        sum += total(out, outputs);
        row = row + 1 == count ? 0 : row + 1;
    }
    return sum;
}

/* The same for a step that does not work in place: x and next change places after each call. */
double drive_kernel(kernel_function *step, int64_t n, const double *rows, int64_t count,
                    int64_t width, double *x, double *next, const double *p, double *y,
                    int64_t outputs)
{
    double sum = 0.0;
    for (int64_t i = 0, row = 0; i < n; i++) {
        step(rows + width * row, x, p, next, y);
        sum += total(y, outputs);
        double *const last = x;
        x = next;
        next = last;
        row = row + 1 == count ? 0 : row + 1;
    }
    return sum;
}

/* The same for a plant step, without random numbers: it takes the step's number, and has no
 * outputs. */
double drive_plant(plant_function *step, int64_t n, const double *rows, int64_t count,
                   int64_t width, double *x, double *next, const double *p)
{
    for (int64_t i = 0, row = 0; i < n; i++) {
        const double index = (double)i;
        step(&index, rows + width * row, x, p, x, next);
        double *const last = x;
        x = next;
        next = last;
        row = row + 1 == count ? 0 : row + 1;
    }
    return x[0];
}
