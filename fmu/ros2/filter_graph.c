/* Other endpoints on the node's topics: those that void its promise, and incompatible ones. */
#include "filter_node.h"

#include <stdio.h>
#include <string.h>

#include <rcl/error_handling.h>
#include <rcl/graph.h>
#include <rmw/get_topic_endpoint_info.h>

#define NAMED 128
#define LEASE "a node that ended abruptly is listed until its lease ends, some 20 s"

typedef rmw_topic_endpoint_info_t endpoint;
typedef rcl_topic_endpoint_info_array_t endpoints;
typedef rcl_ret_t (*look_up)(const rcl_node_t *, rcl_allocator_t *, const char *, bool, endpoints *);

/* All that publish on a topic, or read it; none where nothing can be learnt. */
static endpoints found_on(filter_node *n, look_up look, const char *topic)
{
    rcl_allocator_t allocator = rcl_get_default_allocator();
    endpoints found = rmw_get_zero_initialized_topic_endpoint_info_array();

    if (look(&n->node, &allocator, topic, false, &found) != RCL_RET_OK) {
        rcl_reset_error();
        found = rmw_get_zero_initialized_topic_endpoint_info_array();
    }
    return found;
}

static void done_with(endpoints *found)
{
    rcl_allocator_t allocator = rcl_get_default_allocator();

    (void)!rmw_topic_endpoint_info_array_fini(found, &allocator);
}

/* Name of a node; one that was just discovered has none yet, which rmw reports in capitals. */
static const char *full_name(const endpoint *one, char *text)
{
    if (strstr(one->node_name, "_UNKNOWN_")) {
        return "a node that has not told its name";
    }
    snprintf(text, NAMED, "%.60s/%.60s", strcmp(one->node_namespace, "/") ? one->node_namespace : "", one->node_name);
    return text;
}

static size_t add(char *names, size_t used, const char *name)
{
    return used < ROOM / 4 ? used + (size_t)snprintf(names + used, ROOM / 2 - used, "%s%s", used ? ", " : "", name) : used;
}

/* Other publishers of the commands that go to the base. */
static int rivals(filter_node *n, char *text)
{
    const char *topic = rcl_publisher_get_topic_name(&n->out);
    endpoints found = found_on(n, rcl_get_publishers_info_by_topic, topic);
    char names[ROOM / 2] = "", name[NAMED];
    size_t used = 0;
    int own = 0;

    for (size_t k = 0; k < found.size; ++k) {
        const char *other = full_name(&found.info_array[k], name);

        if (strcmp(other, rcl_node_get_fully_qualified_name(&n->node))) {
            used = add(names, used, other);
        } else if (own++) {
            used = add(names, used, "a second node of this one's own name");
        }
    }
    done_with(&found);
    snprintf(text, ROOM, "other publishers on %.60s: %.240s. The promise is void while one of them sends; " LEASE ".",
        topic, names);
    return used > 0;
}

/* Middle of a sentence on an endpoint that does not get what the other sends; else nothing. */
static int unlike(const endpoint *one, const char *type, const rmw_qos_profile_t *sent, const rmw_qos_profile_t *wanted,
    char *text)
{
    rmw_qos_compatibility_type_t fits = RMW_QOS_COMPATIBILITY_OK;
    char why[ROOM / 4] = "";

    if (strcmp(one->topic_type, type)) {
        snprintf(text, ROOM / 2, "as %.60s, where this node has %.60s%s: nothing", one->topic_type, type,
            strstr(type, "/Twist") ? " (stamped=true or false says which)" : "");
        return 1;
    }
    if (rmw_qos_profile_check_compatible(*sent, *wanted, &fits, why, sizeof why) != RMW_RET_OK) {
        rcl_reset_error();
    }
    snprintf(text, ROOM / 2, "with another QoS (%s): nothing", why);
    return fits == RMW_QOS_COMPATIBILITY_ERROR;
}

/* Somebody on a topic who is not heard, or to whom nothing comes. */
static int strangers(filter_node *n, look_up look, const char *topic, const char *type, const rmw_qos_profile_t *own,
    char *text)
{
    const int reads = look == rcl_get_subscriptions_info_by_topic;
    endpoints found = found_on(n, look, topic);
    char name[NAMED], middle[ROOM / 2];
    int stranger = 0;

    for (size_t k = 0; k < found.size && !stranger; ++k) {
        const endpoint *one = &found.info_array[k];

        stranger = unlike(one, type, reads ? own : &one->qos_profile, reads ? &one->qos_profile : own, middle);
        snprintf(text, ROOM, "%s %s %.60s %s %s.", full_name(one, name), reads ? "reads" : "sends on", topic, middle,
            reads ? "reaches it" : "is heard");
    }
    done_with(&found);
    return stranger;
}

int wmr_useless(filter_node *n, char *text)
{
    int problem = rivals(n, text);

    for (int k = COMMANDS; k < CLOCK && !problem; ++k) {
        problem = strangers(n, rcl_get_publishers_info_by_topic, rcl_subscription_get_topic_name(&n->heard[k]),
            wmr_type_name(k), rcl_subscription_get_actual_qos(&n->heard[k]), text);
    }
    text[0] = problem ? text[0] : '\0';
    return problem;
}

int wmr_doubtful(filter_node *n, char *text)
{
    const char *topic = rcl_subscription_get_topic_name(&n->heard[COMMANDS]);
    endpoints found = found_on(n, rcl_get_publishers_info_by_topic, topic);
    const int several = found.size > 1;
    char names[ROOM / 2] = "", name[NAMED];
    size_t used = 0;

    for (size_t k = 0; k < found.size; ++k) {
        used = add(names, used, full_name(&found.info_array[k], name));
    }
    snprintf(text, ROOM, "%zu senders on %.60s: %.160s. What they send is mixed: keep one, or a multiplexer such as "
                         "twist_mux (" LEASE ").", found.size, topic, names);
    done_with(&found);
    if (several || strangers(n, rcl_get_subscriptions_info_by_topic, rcl_publisher_get_topic_name(&n->out),
                       wmr_type_name(COMMANDS), rcl_publisher_get_actual_qos(&n->out), text)) {
        return 1;
    }
    text[0] = '\0';
    return 0;
}
