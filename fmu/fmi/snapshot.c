#include "snapshot.h"

#include <stdlib.h>
#include <string.h>

#define KEPT UINT64_C(0x574d525f53544154)
#define VERSION 1

/* What stands before the plain state, in memory and in bytes alike. */
typedef struct {
    uint64_t magic, version, token, length, checksum;
} header;

typedef struct {
    header head;
    wmr_state state;
} snapshot;

/* FNV-1a, 64 bits. */
static uint64_t hash(const void *data, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)data;
    uint64_t value = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < size; ++i) {
        value = (value ^ bytes[i]) * UINT64_C(0x100000001b3);
    }
    return value;
}

static header header_of(const wmr_state *state)
{
    const char *token = WMR_TOKEN;
    const header made = {KEPT, VERSION, hash(token, strlen(token)), sizeof *state,
                         hash(state, sizeof *state)};
    return made;
}

static wmr_status check(wmr_instance *s, const snapshot *kept)
{
    if (!kept || kept->head.magic != KEPT) {
        return wmr_say(s, WMR_ERROR, "this is not a state of this FMU.");
    }
    return WMR_OK;
}

wmr_status wmr_snapshot_take(wmr_instance *s, void **kept)
{
    snapshot *target = kept ? (snapshot *)*kept : NULL;
    if (!kept || (target && check(s, target) != WMR_OK)) {
        return wmr_say(s, WMR_ERROR, "there is no place to keep the state.");
    }
    target = target ? target : (snapshot *)calloc(1, sizeof *target);
    if (!target) {
        return wmr_say(s, WMR_ERROR, "there is no memory left for a state.");
    }
    memcpy(&target->state, &s->state, sizeof s->state);
    target->head = header_of(&target->state);
    *kept = target;
    return WMR_OK;
}

wmr_status wmr_snapshot_put(wmr_instance *s, const void *kept)
{
    const snapshot *source = (const snapshot *)kept;
    if (check(s, source) != WMR_OK) {
        return WMR_ERROR;
    }
    if (source->state.interface != s->state.interface) {
        return wmr_say(s, WMR_ERROR,
                       "the state belongs to the other interface (co-simulation or model "
                       "exchange).");
    }
    memcpy(&s->state, &source->state, sizeof s->state);
    kind_restore(s);
    return WMR_OK;
}

wmr_status wmr_snapshot_free(wmr_instance *s, void **kept)
{
    if (!kept) {
        return wmr_say(s, WMR_ERROR, "there is no state to free.");
    }
    if (*kept) {
        if (check(s, (const snapshot *)*kept) != WMR_OK) {
            return WMR_ERROR;
        }
        ((snapshot *)*kept)->head.magic = 0;
        free(*kept);
        *kept = NULL;
    }
    return WMR_OK;
}

wmr_status wmr_snapshot_size(wmr_instance *s, const void *kept, size_t *size)
{
    if (!size || check(s, (const snapshot *)kept) != WMR_OK) {
        return wmr_say(s, WMR_ERROR, "the size of this state cannot be told.");
    }
    *size = sizeof(snapshot);
    return WMR_OK;
}

wmr_status wmr_snapshot_write(wmr_instance *s, const void *kept, void *bytes, size_t size)
{
    if (!bytes || size < sizeof(snapshot)) {
        return wmr_say(s, WMR_ERROR, "a state takes %u bytes, not %u.", (unsigned)sizeof(snapshot),
                       (unsigned)size);
    }
    if (check(s, (const snapshot *)kept) != WMR_OK) {
        return WMR_ERROR;
    }
    memcpy(bytes, kept, sizeof(snapshot));
    return WMR_OK;
}

/* Bytes of another model, and altered bytes, are refused. */
static wmr_status check_bytes(wmr_instance *s, const snapshot *read)
{
    const header wanted = header_of(&read->state);
    if (read->head.magic != wanted.magic || read->head.version != wanted.version) {
        return wmr_say(s, WMR_ERROR, "these bytes are not a state that this FMU wrote.");
    }
    if (read->head.token != wanted.token || read->head.length != wanted.length) {
        return wmr_say(s, WMR_ERROR, "these bytes are the state of another model.");
    }
    if (read->head.checksum != wanted.checksum) {
        return wmr_say(s, WMR_ERROR, "these bytes are damaged: their checksum is wrong.");
    }
    return WMR_OK;
}

wmr_status wmr_snapshot_read(wmr_instance *s, const void *bytes, size_t size, void **kept)
{
    if (!bytes || !kept || size != sizeof(snapshot)) {
        return wmr_say(s, WMR_ERROR, "a state takes %u bytes, not %u.", (unsigned)sizeof(snapshot),
                       (unsigned)size);
    }
    snapshot *made = (snapshot *)calloc(1, sizeof *made);
    if (!made) {
        return wmr_say(s, WMR_ERROR, "there is no memory left for a state.");
    }
    memcpy(made, bytes, sizeof *made);
    const wmr_status status = check_bytes(s, made);
    if (status != WMR_OK) {
        free(made);
        return status;
    }
    *kept = made;
    return WMR_OK;
}
