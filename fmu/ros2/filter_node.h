/* wmr_filter on rcl alone: what the node has, and how it is connected.  node_settings.h is generated. */
#ifndef WMR_FILTER_NODE_H
#define WMR_FILTER_NODE_H

#include <diagnostic_msgs/msg/diagnostic_array.h>
#include <geometry_msgs/msg/twist.h>
#include <geometry_msgs/msg/twist_stamped.h>
#include <nav_msgs/msg/odometry.h>
#include <rcl/rcl.h>
#include <rosgraph_msgs/msg/clock.h>
#include <sensor_msgs/msg/laser_scan.h>
#include <std_msgs/msg/bool.h>
#include <std_msgs/msg/float64_multi_array.h>

#include "filter_core.h"
#include "node_settings.h"

#ifdef WMR_SPEED_LIMIT
#include <nav2_msgs/msg/speed_limit.h>
#endif

#define NAME "wmr_filter"
#define ROOM 512
/* Values of the diagnostics: flags, v, omega, other parts, free distances; of each message taken and refused; of each
   laser. */
#define WMR_DETAILS (5 + 2 * WMR_REASONS + WMR_HEARD * (2 + WMR_REASONS))
#ifdef WMR_AT_FREE
#define WMR_HEARD WMR_SOURCES
#else
#define WMR_HEARD 0
#endif

#if WMR_STAMPED
typedef geometry_msgs__msg__TwistStamped command;
#else
typedef geometry_msgs__msg__Twist command;
#endif

/* Topics that are read, by index; FREE and later ones are lasers, if there are any. */
enum {
    COMMANDS,
    ODOMETRY,
    STOP,
#ifdef WMR_AT_LIMITS
    V_MAX,
    V_MIN,
    ENABLE,
#endif
#ifdef WMR_SPEED_LIMIT
    SPEED_LIMIT,
#endif
#ifdef WMR_AT_FREE
    FREE,
    LAST_FREE = FREE + WMR_SOURCES - 1,
#endif
    CLOCK,
    TOPICS
};

typedef struct {
    rcl_context_t context;
    rcl_node_t node;
    rcl_publisher_t out, diagnostics;
    rcl_subscription_t heard[TOPICS];
    rcl_service_t reset;
    rcl_wait_set_t waits;
    int topics; /* without /clock if time is not simulated */
    wmr_filter_core core;
    command in, sent;
    nav_msgs__msg__Odometry odometry;
    std_msgs__msg__Bool stop;
    geometry_msgs__msg__Twist limit;
    std_msgs__msg__Bool enable;
    std_msgs__msg__Float64MultiArray free;
    sensor_msgs__msg__LaserScan scan;
#ifdef WMR_SPEED_LIMIT
    nav2_msgs__msg__SpeedLimit speed_limit;
#endif
    rosgraph_msgs__msg__Clock clock;
    diagnostic_msgs__msg__DiagnosticArray told;
    const char *free_topics[WMR_HEARD + 1]; /* number of topics with free distances */
    int64_t simulated_now, grave, passing, refused_at, never;
    int64_t more_parts, with_parts; /* whether, and how many, commands had parts that the base cannot follow */
    char useless[ROOM], doubtful[ROOM]; /* last problem found in the graph; empty if there is none */
} filter_node;

/* Types of what is heard, as the graph names them. */
const char *wmr_type_name(int place);

/* Ends the process with a sentence if a call fails. */
void wmr_check(rcl_ret_t result, const char *what);

/* Reads the arguments; creates messages, publishers, subscriptions, the service and a wait set, all of which live as
   long as the process.  Ends the process with a sentence if this fails. */
void wmr_connect(filter_node *n, int argc, const char *const *argv);

/* True if another publisher voids the node's promise, or if a sender's messages cannot be received; writes a sentence
   on it to a text of ROOM. */
int wmr_useless(filter_node *n, char *text);

/* True if a topic that the node reads has several senders, or somebody does not get what the node sends. */
int wmr_doubtful(filter_node *n, char *text);

#endif
