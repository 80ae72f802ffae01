/* Points that lasers see, in the base's frame, and the free distances of a disc among them.  No heap, no globals; angles
   in rad, lengths in m.  gate_numbers.h is generated: poses of the lasers, radius, ignored angles. */
#ifndef WMR_SCAN_CORE_H
#define WMR_SCAN_CORE_H

#include <stdint.h>

/* Most lasers, and most beams of one. */
#define WMR_LASERS 4
#define WMR_BEAMS 4096

/* A message: angle of the first beam, angle between two, least and largest range, and the ranges. */
typedef struct {
    double first, step, least, most;
    int64_t count;
    const float *ranges;
} wmr_beams;

/* Summary of a laser's last message: points, beams that count as 0 m, range and angle of the nearest other one, middle and
   half of the angle that no beam covers (half 0: it covers all). */
typedef struct {
    int64_t points, blind;
    double nearest, nearest_at, gap, half;
} wmr_sight;

/* Sides that can never be free: bits. */
enum { WMR_AHEAD = 1, WMR_BEHIND = 2 };

/* True if the message has usable angles, ranges and number of beams. */
int64_t wmr_scan_usable(const wmr_beams *beams);

/* Takes the message of a laser. */
void wmr_scan_take(int64_t laser, const wmr_beams *beams, wmr_sight *seen, double (*points)[2]);

/* Ways ahead and behind until the disc meets something, while its heading stays within ``window`` (left, right).
   ``points``: WMR_BEAMS for each laser, two numbers each. */
void wmr_scan_ways(const wmr_sight *seen, const double *points, const double *window, double *ways);

/* Sides that are never free, since no beam covers what is there, even with the smallest window. */
int64_t wmr_scan_never(const wmr_sight *seen);

#endif
