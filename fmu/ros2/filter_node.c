/* wmr_filter on rcl alone: commands in, commands out that keep a base within its limits.  What it decides is in
   filter_core.c, how it is connected in filter_connect.c, whom it finds in the graph in filter_graph.c.  One thread; time-outs and ticks are on the steady clock. */
#define _GNU_SOURCE
#include "filter_node.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#include <diagnostic_msgs/msg/diagnostic_status.h>
#include <diagnostic_msgs/msg/key_value.h>
#include <rcl/error_handling.h>
#include <rcutils/logging_macros.h>
#include <rosidl_runtime_c/string_functions.h>
#include <std_srvs/srv/trigger.h>

#define SECOND INT64_C(1000000000)
/* Time between two looks for those who make the node useless, before it starts. */
#define AGAIN (SECOND / 20)
/* Longest wait for readers to take the node's last zero. */
#define LAST_ZERO SECOND

#if WMR_STAMPED
#define TWIST(message) (message).twist
#else
#define TWIST(message) (message)
#endif

static volatile sig_atomic_t ended;

static void end(int number)
{
    (void)number;
    ended = 1;
}

static int64_t clock_of(clockid_t id)
{
    struct timespec now;

    clock_gettime(id, &now);
    return now.tv_sec * SECOND + now.tv_nsec;
}

static int64_t ns_of(const builtin_interfaces__msg__Time *stamp)
{
    return stamp->sec * SECOND + stamp->nanosec;
}

static void stamp_it(builtin_interfaces__msg__Time *stamp, int64_t ns)
{
    stamp->sec = (int32_t)(ns / SECOND);
    stamp->nanosec = (uint32_t)(ns % SECOND);
}

/* Words for the bits that a table contains. */
static const char *named(const wmr_word *table, int count, int64_t bits, char *text)
{
    size_t used = 0;

    text[0] = '\0';
    for (int k = 0; k < count && used < ROOM; ++k) {
        if (bits & table[k].bit) {
            used += (size_t)snprintf(text + used, ROOM - used, "%s%s", used ? ", " : "", table[k].word);
        }
    }
    return text;
}

static int64_t ros_time(const filter_node *n)
{
    return n->topics == TOPICS ? n->simulated_now : clock_of(CLOCK_REALTIME);
}

/* Both clocks; what happened to them goes into the log. */
static wmr_moment look(filter_node *n)
{
    const wmr_moment now = {ros_time(n), clock_of(CLOCK_MONOTONIC), n->topics == TOPICS};
    const int64_t happened = wmr_filter_core_see(&n->core, &now);
    char text[ROOM];

    n->passing |= happened;
    if (happened) {
        RCUTILS_LOG_WARN_NAMED(NAME, "clock: %s", named(wmr_happenings, WMR_HAPPENINGS, happened, text));
    }
    return now;
}

static void put(diagnostic_msgs__msg__KeyValue *pair, const char *key, const char *value)
{
    rosidl_runtime_c__String__assign(&pair->key, key);
    rosidl_runtime_c__String__assign(&pair->value, value);
}

static diagnostic_msgs__msg__KeyValue *put_counts(
    diagnostic_msgs__msg__KeyValue *pair, const char *what, const wmr_intake *intake)
{
    char text[ROOM], number[ROOM];

    for (int64_t reason = 0; reason < WMR_REASONS; ++reason) {
        snprintf(text, ROOM, "%ss %s", what, reason ? wmr_reason(reason) : "taken");
        snprintf(number, ROOM, "%lld", (long long)(reason ? intake->refused[reason] : intake->taken));
        put(pair++, text, number);
    }
    return pair;
}

static diagnostic_msgs__msg__KeyValue *put_sight(
    diagnostic_msgs__msg__KeyValue *pair, const char *what, const wmr_sight *seen)
{
    char text[ROOM], number[ROOM];

    snprintf(text, ROOM, "%s blind beams", what);
    snprintf(number, ROOM, "%lld", (long long)seen->blind);
    put(pair++, text, number);
    snprintf(text, ROOM, "%s nearest beam", what);
    snprintf(number, ROOM, "%.3f m at %.3f rad", seen->nearest, seen->nearest_at);
    put(pair++, text, number);
    return pair;
}

/* Text of ROOM, and what to do if something is too near. */
static const char *with_remedy(int64_t flags, char *text)
{
    const size_t used = strlen(text);

    if (flags & WMR_NEAR && WMR_REMEDY[0]) {
        snprintf(text + used, ROOM - used, "; %s", WMR_REMEDY);
    }
    return text;
}

static void publish_diagnostics(filter_node *n)
{
    diagnostic_msgs__msg__DiagnosticStatus *status = n->told.status.data;
    diagnostic_msgs__msg__KeyValue *pair = status->values.data;
    const int64_t flags = n->core.flags;
    char text[ROOM], number[ROOM];

    status->level = diagnostic_msgs__msg__DiagnosticStatus__OK;
    strcpy(text, "driving");
    if (n->useless[0] || flags & WMR_ERRORS) {
        status->level = diagnostic_msgs__msg__DiagnosticStatus__ERROR;
        n->useless[0] ? strcpy(text, n->useless) : (char *)named(wmr_flags, WMR_FLAGS, flags & WMR_ERRORS, text);
    } else if (flags & WMR_WARNINGS || n->passing || n->more_parts) {
        status->level = diagnostic_msgs__msg__DiagnosticStatus__WARN;
        strcpy(text, "other-parts");
        if (flags & WMR_WARNINGS) {
            named(wmr_flags, WMR_FLAGS, flags & WMR_WARNINGS, text);
        } else if (n->passing) {
            named(wmr_happenings, WMR_HAPPENINGS, n->passing, text);
        }
    } else if (n->doubtful[0]) {
        status->level = diagnostic_msgs__msg__DiagnosticStatus__WARN;
        strcpy(text, n->doubtful);
    }
    n->passing = n->more_parts = 0;
    rosidl_runtime_c__String__assign(&status->message, with_remedy(flags, text));
    put(pair++, "flags", named(wmr_flags, WMR_FLAGS, flags, text));
    for (int k = 0; k < 2; ++k) {
        snprintf(number, ROOM, "%.4f", n->core.sent[k]);
        put(pair++, k ? "omega" : "v", number);
    }
    pair = put_counts(pair, "command", &n->core.commands);
    pair = put_counts(pair, "odometry", &n->core.odometry);
    for (int k = 0; k < WMR_HEARD; ++k) {
        pair = put_counts(pair, n->free_topics[k], &n->core.frees[k]);
        pair = put_sight(pair, n->free_topics[k], &n->core.sights[k]);
    }
    snprintf(number, ROOM, "%.3f m, %.3f m, %.3f rad, %.3f rad", n->core.free[0], n->core.free[1], n->core.free[2],
        n->core.free[3]);
    put(pair++, "free", number);
    snprintf(number, ROOM, "%lld", (long long)n->with_parts);
    put(pair, "commands with other parts", number);
    stamp_it(&n->told.header.stamp, ros_time(n));
    (void)!rcl_publish(&n->diagnostics, &n->told, NULL);
}

static void publish(filter_node *n, double v, double omega)
{
    TWIST(n->sent).linear.x = v;
    TWIST(n->sent).angular.z = omega;
#if WMR_STAMPED
    stamp_it(&n->sent.header.stamp, ros_time(n));
#endif
    if (rcl_publish(&n->out, &n->sent, NULL) != RCL_RET_OK) {
        RCUTILS_LOG_ERROR_NAMED(NAME, "a command could not be sent: %s", rcl_get_error_string().str);
        rcl_reset_error();
    }
}

/* Sends the core's command, and logs serious flags when they change. */
static void answer(filter_node *n, int64_t answered, int64_t stamp, const wmr_moment *now)
{
    int64_t grave;
    char text[ROOM];

    wmr_filter_core_tick(&n->core, answered, stamp, now);
    publish(n, n->core.sent[0], n->core.sent[1]);
    grave = n->core.flags & (WMR_ERRORS | WMR_WARNINGS);
    if (grave != n->grave) {
        n->grave = grave;
        named(wmr_flags, WMR_FLAGS, grave, text);
        RCUTILS_LOG_INFO_NAMED(NAME, "%s", grave ? with_remedy(grave, text) : "driving");
        publish_diagnostics(n);
    }
}

/* Message of a topic, for the report of its refusal. */
typedef struct {
    const char *what, *frame;
    int64_t stamp, timeout;
    const char *patience; /* parameter of the time-out */
} received;

/* Received and expected value, after the reason. */
static const char *explained(const received *message, int64_t reason, const wmr_moment *now, char *text)
{
    const double late = (double)(now->ros - message->stamp) * 1e-9;

    if (reason == WMR_WRONG_FRAME) {
        snprintf(text, ROOM, ": it is '%s', wanted is '%s'", message->frame, WMR_BASE_FRAME);
    } else if (reason == WMR_TOO_OLD) {
        snprintf(text, ROOM, ": %.3g s by its stamp, at most %.3g s (%s)", late, (double)message->timeout * 1e-9,
            message->patience);
    } else if (reason == WMR_FUTURE) {
        snprintf(text, ROOM, ": its stamp is %.3g s ahead of this node's clock", -late);
    } else {
        text[0] = '\0';
    }
    return text;
}

static void tell_refusal(filter_node *n, const received *message, int64_t reason, const wmr_moment *now)
{
    char text[ROOM];

    if (reason && now->steady - n->refused_at > SECOND) {
        n->refused_at = now->steady;
        RCUTILS_LOG_WARN_NAMED(
            NAME, "%s refused: %s%s", message->what, wmr_reason(reason), explained(message, reason, now, text));
    }
}

/* True if a twist has parts that two driven wheels cannot follow. */
static int has_other_parts(const geometry_msgs__msg__Twist *twist)
{
    return twist->linear.y != 0.0 || twist->linear.z != 0.0 || twist->angular.x != 0.0 || twist->angular.y != 0.0;
}

static void on_command(filter_node *n)
{
    const wmr_moment now = look(n);
    const double velocity[] = {TWIST(n->in).linear.x, TWIST(n->in).angular.z};
#if WMR_STAMPED
    const int64_t stamp = ns_of(&n->in.header.stamp);
    const char *frame = n->in.header.frame_id.data;
#else
    const int64_t stamp = 0;
    const char *frame = WMR_BASE_FRAME;
#endif
    const received message = {"command", frame, stamp, WMR_COMMAND_TIMEOUT, "command_timeout"};
    const int64_t framed = wmr_frame_fits(WMR_BASE_FRAME, frame, 0);
    int64_t reason;

    if (has_other_parts(&TWIST(n->in))) {
        ++n->with_parts;
        n->more_parts = 1;
    }
    if (WMR_REFUSES_PARTS && has_other_parts(&TWIST(n->in))) {
        tell_refusal(n, &message, wmr_intake_refuse(&n->core.commands, WMR_OTHER_PARTS), &now);
        return;
    }
    reason = wmr_filter_core_command(&n->core, velocity, framed, stamp, &now);
    tell_refusal(n, &message, reason, &now);
    if (WMR_AT_ONCE && !reason && wmr_filter_core_due(&n->core, stamp, &now)) {
        answer(n, 1, stamp, &now);
    }
}

static void on_odometry(filter_node *n)
{
    const wmr_moment now = look(n);
    const geometry_msgs__msg__Twist *twist = &n->odometry.twist.twist;
    const geometry_msgs__msg__Quaternion *turn = &n->odometry.pose.pose.orientation;
    const double velocity[] = {twist->linear.x, twist->angular.z};
    const double quaternion[] = {turn->x, turn->y, turn->z, turn->w};
    const char *frame = n->odometry.child_frame_id.data;
    const int64_t framed = wmr_frame_fits(WMR_BASE_FRAME, frame, 0), stamp = ns_of(&n->odometry.header.stamp);
    const received message = {"odometry", frame, stamp, WMR_ODOMETRY_TIMEOUT, "odometry_timeout"};

    tell_refusal(n, &message, wmr_filter_core_odometry(&n->core, velocity, quaternion, framed, stamp, &now), &now);
}

static void on_stop(filter_node *n)
{
    const wmr_moment now = look(n);

    n->core.stop = n->stop.data;
    if (n->core.stop) {
        answer(n, 0, 0, &now);
    }
}

#ifdef WMR_AT_LIMITS
static void on_limit(filter_node *n, int64_t topic, double first, double second)
{
    const wmr_moment now = look(n);
    const double pair[] = {first, second};

    wmr_filter_core_limit(&n->core, topic, pair, &now);
}
#endif

#if WMR_SCANS
/* Tells of sides that no beam covers, when they change. */
static void tell_never(filter_node *n)
{
    static const char *const sides[] = {"", "ahead", "behind", "ahead and behind"};
    const int64_t never = wmr_filter_core_never(&n->core);

    if (never && never != n->never) {
        RCUTILS_LOG_WARN_NAMED(NAME,
            "no beam covers %s: no command that way is ever sent. Add a laser, or give ignore.", sides[never]);
    }
    n->never = never;
}

static void on_scan(filter_node *n, int64_t laser)
{
    const wmr_moment now = look(n);
    const sensor_msgs__msg__LaserScan *scan = &n->scan;
    const wmr_beams beams = {scan->angle_min, scan->angle_increment, scan->range_min, scan->range_max,
        (int64_t)scan->ranges.size, scan->ranges.data};
    const int64_t stamp = ns_of(&scan->header.stamp);
    const received message = {n->free_topics[laser], "", stamp, WMR_FREE_TIMEOUT, "filter.free_age of the scenario"};

    tell_refusal(n, &message, wmr_filter_core_scan(&n->core, laser, &beams, stamp, &now), &now);
    tell_never(n);
}
#elif defined WMR_AT_FREE
static void on_free(filter_node *n)
{
    const wmr_moment now = look(n);
    const received message = {"free", "", 0, WMR_FREE_TIMEOUT, ""};

    tell_refusal(n, &message,
        wmr_filter_core_free(&n->core, n->free.data.data, (int64_t)n->free.data.size, &now), &now);
}
#endif

static void on_reset(filter_node *n)
{
    rmw_request_id_t caller;
    std_srvs__srv__Trigger_Request request;
    std_srvs__srv__Trigger_Response response;

    std_srvs__srv__Trigger_Request__init(&request);
    std_srvs__srv__Trigger_Response__init(&response);
    if (rcl_take_request(&n->reset, &caller, &request) == RCL_RET_OK) {
        response.success = wmr_filter_core_reset(&n->core);
        rosidl_runtime_c__String__assign(&response.message, response.success ? "" : "the topic ~/stop still says true");
        (void)!rcl_send_response(&n->reset, &caller, &response);
    }
    rcl_reset_error();
    std_srvs__srv__Trigger_Request__fini(&request);
    std_srvs__srv__Trigger_Response__fini(&response);
}

/* Checks the graph, and logs other nodes that make this one useless. */
static void look_around(filter_node *n)
{
    if (wmr_useless(n, n->useless)) {
        RCUTILS_LOG_ERROR_NAMED(NAME, "%s", n->useless);
    }
    wmr_doubtful(n, n->doubtful);
}

/* Ends the process with a sentence where somebody makes the node useless from the start. */
static void refuse_to_start(filter_node *n)
{
    const struct timespec pause = {0, AGAIN};

    for (int64_t end = clock_of(CLOCK_MONOTONIC) + WMR_DISCOVERY; !ended && clock_of(CLOCK_MONOTONIC) < end;) {
        if (wmr_useless(n, n->useless)) {
            fprintf(stderr, "error: %s\n", n->useless);
            exit(2);
        }
        nanosleep(&pause, NULL);
    }
}

/* Memory for a message of a topic. */
static void *message_of(filter_node *n, int place)
{
    switch (place) {
    case COMMANDS:
        return &n->in;
    case ODOMETRY:
        return &n->odometry;
    case STOP:
        return &n->stop;
    case CLOCK:
        return &n->clock;
#ifdef WMR_AT_LIMITS
    case V_MAX:
    case V_MIN:
        return &n->limit;
    case ENABLE:
        return &n->enable;
#endif
#ifdef WMR_SPEED_LIMIT
    case SPEED_LIMIT:
        return &n->speed_limit;
#endif
    default:
        return WMR_SCANS ? (void *)&n->scan : (void *)&n->free;
    }
}

/* Acts on the message of a topic that was just taken. */
static void act_on(filter_node *n, int place)
{
    switch (place) {
    case COMMANDS:
        on_command(n);
        break;
    case ODOMETRY:
        on_odometry(n);
        break;
    case STOP:
        on_stop(n);
        break;
    case CLOCK:
        n->simulated_now = ns_of(&n->clock.clock);
        break;
#ifdef WMR_AT_LIMITS
    case V_MAX:
    case V_MIN:
        on_limit(n, place == V_MAX ? WMR_V_MAX : WMR_V_MIN, n->limit.linear.x, n->limit.angular.z);
        break;
    case ENABLE:
        on_limit(n, WMR_ENABLE, n->enable.data, 0.0);
        break;
#endif
#ifdef WMR_SPEED_LIMIT
    case SPEED_LIMIT:
        on_limit(n, WMR_SPEED, n->speed_limit.speed_limit, n->speed_limit.percentage);
        break;
#endif
    default:
#if WMR_SCANS
        on_scan(n, place - FREE);
#elif defined WMR_AT_FREE
        on_free(n);
#endif
        break;
    }
}

/* Waits for a message or until a time [steady], and acts on it. */
static void wait_until(filter_node *n, int64_t time)
{
    const int64_t left = time - clock_of(CLOCK_MONOTONIC);
    size_t place;

    wmr_check(rcl_wait_set_clear(&n->waits), "waiting");
    for (int k = 0; k < n->topics; ++k) {
        wmr_check(rcl_wait_set_add_subscription(&n->waits, &n->heard[k], &place), "waiting");
    }
    wmr_check(rcl_wait_set_add_service(&n->waits, &n->reset, &place), "waiting");
    (void)!rcl_wait(&n->waits, left > 0 ? left : 0);
    rcl_reset_error();
    for (int k = n->topics - 1; k >= 0; --k) { /* the clock first: the others are of its time */
        if (!n->waits.subscriptions[k] || rcl_take(&n->heard[k], message_of(n, k), NULL, NULL) != RCL_RET_OK) {
            rcl_reset_error();
        } else {
            act_on(n, k);
        }
    }
    if (n->waits.services[0]) {
        on_reset(n);
    }
}

static void spin(filter_node *n)
{
    const int64_t step = WMR_AT_ONCE ? WMR_PERIOD / 4 : WMR_PERIOD;
    int64_t tick = clock_of(CLOCK_MONOTONIC) + step, second = tick;

    while (!ended) {
        wait_until(n, tick);
        if (clock_of(CLOCK_MONOTONIC) >= tick) {
            const wmr_moment now = look(n);

            if (!WMR_AT_ONCE || wmr_filter_core_overdue(&n->core, &now)) {
                answer(n, 0, 0, &now);
            }
            tick += (now.steady - tick) / step * step + step; /* missed ticks are not repeated */
            if (now.steady >= second) {
                second = now.steady + SECOND;
                look_around(n);
                publish_diagnostics(n);
            }
        }
    }
}

int main(int argc, char **argv)
{
    static filter_node n;
    const struct sigaction action = {.sa_handler = end};

    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    wmr_filter_core_make(&n.core);
    wmr_connect(&n, argc, (const char *const *)argv);
    refuse_to_start(&n);
    (void)!mlockall(MCL_CURRENT | MCL_FUTURE); /* where it is allowed */
    RCUTILS_LOG_INFO_NAMED(NAME, "%s", WMR_KEPT);
    spin(&n);
    publish(&n, 0.0, 0.0);
    (void)!rcl_publisher_wait_for_all_acked(&n.out, LAST_ZERO);
    return 0;
}
