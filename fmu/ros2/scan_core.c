#include "scan_core.h"

#include <math.h>
#include <string.h>

#include "gate.h"
#include "gate_numbers.h"

#if WMR_SCANS

#define TURN 6.283185307179586
/* Angle between two rays through what no beam covers. */
#define APART 0.017
/* Points at the disc's edge are put just inside it, where rounding cannot miss them. */
#define INSIDE 0.999

typedef struct {
    double middle, half;
} arc;

static const double poses[WMR_SCANS][3] = WMR_SCAN_POSES;
static const double ignored[][2] = WMR_IGNORED;

#define IGNORED ((int64_t)(sizeof ignored / sizeof *ignored))

static int apart(arc one, arc other)
{
    return fabs(remainder(one.middle - other.middle, TURN)) > one.half + other.half;
}

static arc ignored_arc(int64_t k)
{
    const arc found = {(ignored[k][0] + ignored[k][1]) / 2, (ignored[k][1] - ignored[k][0]) / 2};

    return found;
}

static int is_ignored(double angle)
{
    const arc ray = {angle, 0.0};
    int found = 0;

    for (int64_t k = 0; k < IGNORED; ++k) {
        found |= ignored[k][0] < ignored[k][1] && !apart(ignored_arc(k), ray);
    }
    return found;
}

/* Point at a range along a beam of a laser. */
static void point_at(const double *pose, double angle, double range, double *point)
{
    point[0] = pose[0] + range * cos(pose[2] + angle);
    point[1] = pose[1] + range * sin(pose[2] + angle);
}

/* Point of the disc's edge along a beam of a laser, which is inside the disc: what is there counts as 0 m. */
static void edge_at(const double *pose, double angle, double *point)
{
    const double along = pose[0] * cos(pose[2] + angle) + pose[1] * sin(pose[2] + angle);
    const double radius = INSIDE * WMR_RADIUS, squared = pose[0] * pose[0] + pose[1] * pose[1];

    point_at(pose, angle, sqrt(fmax(0.0, radius * radius - squared + along * along)) - along, point);
}

int64_t wmr_scan_usable(const wmr_beams *b)
{
    return isfinite(b->first) && isfinite(b->step) && b->step != 0.0 && isfinite(b->most) && b->most > 0.0 &&
           b->least >= 0.0 && b->count > 0 && b->count <= WMR_BEAMS;
}

/* Range of a beam; negative: it counts as 0 m.  Infinity is nothing as far as the laser sees. */
static double range_of(const wmr_beams *b, int64_t k)
{
    const double range = b->ranges[k];

    if (range == INFINITY) {
        return b->most;
    }
    if (isnan(range) || range == 0.0 || range > b->most) {
        return WMR_NO_RETURN_IS_FAR ? b->most : -1.0;
    }
    return range < b->least ? -1.0 : range;
}

void wmr_scan_take(int64_t laser, const wmr_beams *b, wmr_sight *seen, double (*points)[2])
{
    const double covered = (double)b->count * fabs(b->step);

    memset(seen, 0, sizeof *seen);
    seen->nearest = INFINITY;
    for (int64_t k = 0; k < b->count; ++k) {
        const double angle = b->first + (double)k * b->step, range = range_of(b, k);

        if (is_ignored(angle)) {
            continue;
        }
        if (range < 0.0) {
            ++seen->blind;
            edge_at(poses[laser], angle, points[seen->points]);
        } else {
            point_at(poses[laser], angle, range, points[seen->points]);
        }
        ++seen->points;
        if (range >= 0.0 && range < seen->nearest) {
            seen->nearest = range;
            seen->nearest_at = angle;
        }
    }
    seen->gap = b->first + (double)(b->count - 1) / 2 * b->step + TURN / 2;
    seen->half = TURN - covered > fabs(b->step) ? (TURN - covered) / 2 : 0.0;
}

/* True if other lasers cover a whole ray that begins at the disc's edge. */
static int is_covered(const wmr_sight *seen, int64_t laser, double angle, const double *edge)
{
    for (int64_t k = 0; k < WMR_SCANS; ++k) {
        const double *pose = poses[k];
        const double near = atan2(edge[1] - pose[1], edge[0] - pose[0]), far = poses[laser][2] + angle;
        const double swept = remainder(far - near, TURN);
        const arc ray = {near - pose[2] + swept / 2, fabs(swept) / 2}, gap = {seen[k].gap, seen[k].half};
        int covers = k != laser && (gap.half == 0.0 || apart(gap, ray));

        for (int64_t i = 0; i < IGNORED; ++i) {
            covers = covers && (ignored[i][0] >= ignored[i][1] || apart(ignored_arc(i), ray));
        }
        if (covers) {
            return 1;
        }
    }
    return 0;
}

static void meet(const double *point, const double *window, double *ways)
{
    const double u[] = {point[0], point[1], window[0], window[1], WMR_RADIUS};
    double y[2];

    wmr_way(u, y);
    ways[0] = fmin(ways[0], y[0]);
    ways[1] = fmin(ways[1], y[1]);
}

/* Where no laser sees, an obstacle may be at the disc's edge. */
static void over_gaps(const wmr_sight *seen, const double *window, double *ways)
{
    for (int64_t k = 0; k < WMR_SCANS; ++k) {
        const double half = seen[k].half;
        const int64_t rays = half > 0.0 ? (int64_t)(2 * half / APART) + 1 : -1;
        double point[2];

        for (int64_t i = 0; i <= rays; ++i) {
            const double angle = seen[k].gap - half + 2 * half * (double)i / (double)rays;

            edge_at(poses[k], angle, point);
            if (!is_ignored(angle) && !is_covered(seen, k, angle, point)) {
                meet(point, window, ways);
            }
        }
    }
}

void wmr_scan_ways(const wmr_sight *seen, const double *points, const double *window, double *ways)
{
    ways[0] = ways[1] = INFINITY;
    over_gaps(seen, window, ways);
    for (int64_t k = 0; k < WMR_SCANS; ++k) {
        for (int64_t i = 0; i < seen[k].points; ++i) {
            meet(points + 2 * (k * WMR_BEAMS + i), window, ways);
        }
    }
}

int64_t wmr_scan_never(const wmr_sight *seen)
{
    const double window[] = {WMR_SMALLEST, WMR_SMALLEST};
    double ways[] = {INFINITY, INFINITY};

    over_gaps(seen, window, ways);
    return (ways[0] <= 0.0 ? WMR_AHEAD : 0) | (ways[1] <= 0.0 ? WMR_BEHIND : 0);
}

#endif
