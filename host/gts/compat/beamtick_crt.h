/* Functions of the C runtime that programs for Windows use in place of the standard's. */
#ifndef BEAMTICK_CRT_H
#define BEAMTICK_CRT_H

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define printf_s printf
#define fprintf_s fprintf
#define scanf_s scanf
#define sscanf_s sscanf
#define _snprintf snprintf
#define _stricmp strcasecmp
#define _strnicmp strncasecmp
#define stricmp strcasecmp
#define _strdup strdup

static inline int fopen_s(FILE **file, const char *name, const char *mode)
{
    *file = fopen(name, mode);
    return *file == NULL;
}

#ifdef __cplusplus
/* With the size, or with an array that has one. */
template <class... Values> inline int sprintf_s(char *to, size_t size, const char *format, Values... values)
{
    return snprintf(to, size, format, values...);
}
template <size_t size, class... Values> inline int sprintf_s(char (&to)[size], const char *format, Values... values)
{
    return snprintf(to, size, format, values...);
}
inline int strcpy_s(char *to, size_t size, const char *from) { return snprintf(to, size, "%s", from) < 0; }
template <size_t size> inline int strcpy_s(char (&to)[size], const char *from) { return strcpy_s(to, size, from); }
inline int strcat_s(char *to, size_t size, const char *from)
{
    size_t used = strlen(to);
    return strcpy_s(to + used, size - used, from);
}
template <size_t size> inline int strcat_s(char (&to)[size], const char *from) { return strcat_s(to, size, from); }
#else
static inline int sprintf_s(char *to, size_t size, const char *format, ...)
{
    va_list values;
    int length;
    va_start(values, format);
    length = vsnprintf(to, size, format, values);
    va_end(values);
    return length;
}
static inline int strcpy_s(char *to, size_t size, const char *from) { return snprintf(to, size, "%s", from) < 0; }
#endif

static inline char *beamtick_itoa(long value, char *to, int base)
{
    char digits[72], *place = digits + sizeof digits - 1;
    unsigned long left = value < 0 && base == 10 ? 0UL - (unsigned long)value : (unsigned long)value;
    *place = 0;
    if (base < 2 || base > 36) {
        *to = 0;
        return to;
    }
    do {
        *--place = "0123456789abcdefghijklmnopqrstuvwxyz"[left % (unsigned long)base];
        left /= (unsigned long)base;
    } while (left != 0);
    if (value < 0 && base == 10) {
        *--place = '-';
    }
    return (char *)memcpy(to, place, (size_t)(digits + sizeof digits - place));
}
#define _itoa(value, to, base) beamtick_itoa((value), (to), (base))
#define itoa(value, to, base) beamtick_itoa((value), (to), (base))
#define _ltoa(value, to, base) beamtick_itoa((value), (to), (base))

#endif
