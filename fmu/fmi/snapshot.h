/* States of an instance, as copies or as bytes. */
#ifndef WMR_SNAPSHOT_H
#define WMR_SNAPSHOT_H

#include "instance.h"

wmr_status wmr_snapshot_take(wmr_instance *s, void **snapshot);
wmr_status wmr_snapshot_put(wmr_instance *s, const void *snapshot);
wmr_status wmr_snapshot_free(wmr_instance *s, void **snapshot);
wmr_status wmr_snapshot_size(wmr_instance *s, const void *snapshot, size_t *size);
wmr_status wmr_snapshot_write(wmr_instance *s, const void *snapshot, void *bytes, size_t size);
wmr_status wmr_snapshot_read(wmr_instance *s, const void *bytes, size_t size, void **snapshot);

#endif
