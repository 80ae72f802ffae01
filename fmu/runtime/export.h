/* What leaves a library: everything else is hidden. */
#ifndef WMR_EXPORT_H
#define WMR_EXPORT_H

#if defined(_WIN32)
#define WMR_EXPORT __declspec(dllexport)
#else
#define WMR_EXPORT __attribute__((visibility("default")))
#endif

#endif
