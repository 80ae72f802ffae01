#include "filter_node.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <diagnostic_msgs/msg/diagnostic_status.h>
#include <diagnostic_msgs/msg/key_value.h>
#include <rcl/error_handling.h>
#include <rcl/logging.h>
#include <rcl_yaml_param_parser/parser.h>
#include <rosidl_runtime_c/string_functions.h>
#include <std_srvs/srv/trigger.h>

#if WMR_STAMPED
#define COMMAND_TYPE ROSIDL_GET_MSG_TYPE_SUPPORT(geometry_msgs, msg, TwistStamped)
#define COMMAND_MAKE geometry_msgs__msg__TwistStamped__init
#define COMMAND_NAME "geometry_msgs/msg/TwistStamped"
#else
#define COMMAND_TYPE ROSIDL_GET_MSG_TYPE_SUPPORT(geometry_msgs, msg, Twist)
#define COMMAND_MAKE geometry_msgs__msg__Twist__init
#define COMMAND_NAME "geometry_msgs/msg/Twist"
#endif

#if WMR_SCANS
#define FREE_TYPE ROSIDL_GET_MSG_TYPE_SUPPORT(sensor_msgs, msg, LaserScan)
#define FREE_NAME "sensor_msgs/msg/LaserScan"
static const char *const scan_topics[] = WMR_SCAN_TOPICS;
#elif defined WMR_AT_FREE
#define FREE_TYPE ROSIDL_GET_MSG_TYPE_SUPPORT(std_msgs, msg, Float64MultiArray)
#define FREE_NAME "std_msgs/msg/Float64MultiArray"
static const char *const scan_topics[] = {"free"};
#endif

const char *wmr_type_name(int place)
{
    switch (place) {
    case COMMANDS:
        return COMMAND_NAME;
    case ODOMETRY:
        return "nav_msgs/msg/Odometry";
    case STOP:
#ifdef WMR_AT_LIMITS
    case ENABLE:
        return "std_msgs/msg/Bool";
    case V_MAX:
    case V_MIN:
        return "geometry_msgs/msg/Twist";
#else
        return "std_msgs/msg/Bool";
#endif
#ifdef WMR_SPEED_LIMIT
    case SPEED_LIMIT:
        return "nav2_msgs/msg/SpeedLimit";
#endif
#ifdef WMR_AT_FREE
    default:
        return FREE_NAME;
#else
    default:
        return "rosgraph_msgs/msg/Clock";
#endif
    }
}

void wmr_check(rcl_ret_t result, const char *what)
{
    if (result != RCL_RET_OK) {
        fprintf(stderr, "error: %s: %s\n", what, rcl_get_error_string().str);
        exit(2);
    }
}

/* Whether time is simulated; any other parameter is a sentence, since the promise is compiled in. */
static int reads_clock(const rcl_arguments_t *arguments)
{
    rcl_params_t *given = NULL;
    int simulated = 0;

    wmr_check(rcl_arguments_get_param_overrides(arguments, &given), "parameters");
    for (size_t k = 0; given && k < given->num_nodes; ++k) {
        for (size_t i = 0; i < given->params[k].num_params; ++i) {
            const char *name = given->params[k].parameter_names[i];
            const rcl_variant_t *value = &given->params[k].parameter_values[i];

            if (strcmp(name, "use_sim_time") || !value->bool_value) {
                fprintf(stderr, "error: the parameter %s cannot be set: this node has what it keeps compiled in. Write "
                                "it again with wmr-ctrl codegen filter --ros2 --param.\n", name);
                exit(2);
            }
            simulated = *value->bool_value;
        }
    }
    if (given) {
        rcl_yaml_node_struct_fini(given);
    }
    return simulated;
}

static void subscribe(filter_node *n, int place, const rosidl_message_type_support_t *type, const char *topic, int kept)
{
    rcl_subscription_options_t options = rcl_subscription_get_default_options();

    options.qos = rmw_qos_profile_default;
    options.qos.depth = 1;
    options.qos.reliability = kept ? RMW_QOS_POLICY_RELIABILITY_RELIABLE : RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT;
    options.qos.durability = kept ? RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL : RMW_QOS_POLICY_DURABILITY_VOLATILE;
    n->heard[place] = rcl_get_zero_initialized_subscription();
    wmr_check(rcl_subscription_init(&n->heard[place], &n->node, type, topic, &options), topic);
}

static void advertise(
    filter_node *n, rcl_publisher_t *out, const rosidl_message_type_support_t *type, const char *topic, size_t depth)
{
    rcl_publisher_options_t options = rcl_publisher_get_default_options();

    options.qos.depth = depth;
    *out = rcl_get_zero_initialized_publisher();
    wmr_check(rcl_publisher_init(out, &n->node, type, topic, &options), topic);
}

static void make_messages(filter_node *n)
{
    diagnostic_msgs__msg__DiagnosticStatus *status;

    COMMAND_MAKE(&n->in);
    COMMAND_MAKE(&n->sent);
    nav_msgs__msg__Odometry__init(&n->odometry);
    std_msgs__msg__Bool__init(&n->stop);
    geometry_msgs__msg__Twist__init(&n->limit);
    std_msgs__msg__Bool__init(&n->enable);
    std_msgs__msg__Float64MultiArray__init(&n->free);
    sensor_msgs__msg__LaserScan__init(&n->scan);
#ifdef WMR_SPEED_LIMIT
    nav2_msgs__msg__SpeedLimit__init(&n->speed_limit);
#endif
    rosgraph_msgs__msg__Clock__init(&n->clock);
    diagnostic_msgs__msg__DiagnosticArray__init(&n->told);
    diagnostic_msgs__msg__DiagnosticStatus__Sequence__init(&n->told.status, 1);
    status = n->told.status.data;
    diagnostic_msgs__msg__KeyValue__Sequence__init(&status->values, WMR_DETAILS);
    rosidl_runtime_c__String__assign(&status->name, rcl_node_get_fully_qualified_name(&n->node));
#if WMR_STAMPED
    rosidl_runtime_c__String__assign(&n->sent.header.frame_id, WMR_BASE_FRAME);
#endif
}

static filter_node *connected;

/* Ends the node, and with it the threads of DDS: at exit they would run on while the library destroys what they use,
   and one process in a hundred did not end. */
static void disconnect(void)
{
    filter_node *n = connected;

    (void)!rcl_wait_set_fini(&n->waits);
    (void)!rcl_service_fini(&n->reset, &n->node);
    for (int k = 0; k < n->topics; ++k) {
        (void)!rcl_subscription_fini(&n->heard[k], &n->node);
    }
    (void)!rcl_publisher_fini(&n->diagnostics, &n->node);
    (void)!rcl_publisher_fini(&n->out, &n->node);
    (void)!rcl_node_fini(&n->node);
    (void)!rcl_shutdown(&n->context);
    (void)!rcl_context_fini(&n->context);
}

void wmr_connect(filter_node *n, int argc, const char *const *argv)
{
    rcl_allocator_t allocator = rcl_get_default_allocator();
    rcl_init_options_t options = rcl_get_zero_initialized_init_options();
    rcl_node_options_t node_options = rcl_node_get_default_options();
    rcl_service_options_t service_options = rcl_service_get_default_options();

    wmr_check(rcl_init_options_init(&options, allocator), "options");
    n->context = rcl_get_zero_initialized_context();
    wmr_check(rcl_init(argc, argv, &options, &n->context), "arguments");
    if (rcl_arguments_get_count_unparsed_ros(&n->context.global_arguments) > 0) {
        fprintf(stderr, "error: arguments: one after --ros-args is none of ROS 2.\n");
        exit(2);
    }
    wmr_check(rcl_logging_configure(&n->context.global_arguments, &allocator), "logging");
    n->topics = reads_clock(&n->context.global_arguments) ? TOPICS : CLOCK;
    n->node = rcl_get_zero_initialized_node();
    wmr_check(rcl_node_init(&n->node, NAME, "", &n->context, &node_options), "node");
    connected = n;
    atexit(disconnect); /* before what the library registered while the node was made */
    make_messages(n);
    advertise(n, &n->out, COMMAND_TYPE, "cmd_vel", 1);
    advertise(n, &n->diagnostics, ROSIDL_GET_MSG_TYPE_SUPPORT(diagnostic_msgs, msg, DiagnosticArray), "/diagnostics", 10);
    subscribe(n, COMMANDS, COMMAND_TYPE, "cmd_vel_in", 0);
    subscribe(n, ODOMETRY, ROSIDL_GET_MSG_TYPE_SUPPORT(nav_msgs, msg, Odometry), "odom", 0);
    subscribe(n, STOP, ROSIDL_GET_MSG_TYPE_SUPPORT(std_msgs, msg, Bool), "~/stop", 1);
#ifdef WMR_AT_LIMITS
    subscribe(n, V_MAX, ROSIDL_GET_MSG_TYPE_SUPPORT(geometry_msgs, msg, Twist), "~/v_max", 1);
    subscribe(n, V_MIN, ROSIDL_GET_MSG_TYPE_SUPPORT(geometry_msgs, msg, Twist), "~/v_min", 1);
    subscribe(n, ENABLE, ROSIDL_GET_MSG_TYPE_SUPPORT(std_msgs, msg, Bool), "~/enable", 1);
#endif
#ifdef WMR_SPEED_LIMIT
    subscribe(n, SPEED_LIMIT, ROSIDL_GET_MSG_TYPE_SUPPORT(nav2_msgs, msg, SpeedLimit), WMR_SPEED_LIMIT, 1);
#endif
#ifdef WMR_AT_FREE
    for (int k = 0; k < WMR_SOURCES; ++k) {
        n->free_topics[k] = scan_topics[k];
        subscribe(n, FREE + k, FREE_TYPE, WMR_SCANS ? scan_topics[k] : "~/free", 0);
    }
#endif
    if (n->topics == TOPICS) {
        subscribe(n, CLOCK, ROSIDL_GET_MSG_TYPE_SUPPORT(rosgraph_msgs, msg, Clock), "/clock", 0);
    }
    n->reset = rcl_get_zero_initialized_service();
    wmr_check(rcl_service_init(&n->reset, &n->node, ROSIDL_GET_SRV_TYPE_SUPPORT(std_srvs, srv, Trigger), "~/reset",
              &service_options), "~/reset");
    n->waits = rcl_get_zero_initialized_wait_set();
    wmr_check(rcl_wait_set_init(&n->waits, (size_t)n->topics, 0, 0, 0, 1, 0, &n->context, allocator), "waiting");
}
