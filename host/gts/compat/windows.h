/* windows.h for Linux: what console programs for a motion controller use of it. Types, waits and clocks, threads with
 * what they wait for, critical sections, timers, the console's colours. No windows, files or registry.
 *
 * Time is the program's (docs/c.md): the controller's with a virtual link, else the wall clock's. DWORD is an unsigned
 * long, as there; here that has 64 bits where the platform's long has. */
#ifndef BEAMTICK_WINDOWS_H
#define BEAMTICK_WINDOWS_H

#include <ctype.h>
#include <limits.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "beamtick_crt.h"
#include "beamtick_types.h"
#include "beamtick_threads.h"

/* ---- waits and clocks ---- */
static inline void Sleep(DWORD milliseconds)
{
    beamtick_thread_sleep(beamtick_thread_self, milliseconds);
    beamtick_thread_leave();
}

static inline DWORD SleepEx(DWORD milliseconds, BOOL alertable)
{
    (void)alertable;
    Sleep(milliseconds);
    return 0;
}

static inline DWORD GetTickCount(void)
{
    return (DWORD)(beamtick_now() / 1000000u & 0xffffffffu);
}

static inline ULONGLONG GetTickCount64(void)
{
    return beamtick_now() / 1000000u;
}

static inline BOOL QueryPerformanceFrequency(LARGE_INTEGER *frequency)
{
    frequency->QuadPart = 10000000;
    return TRUE;
}

static inline BOOL QueryPerformanceCounter(LARGE_INTEGER *count)
{
    count->QuadPart = (LONGLONG)(beamtick_now() / 100u);
    return TRUE;
}

/* What needs POSIX: not there in strict C (-std=c99). */
#if defined _POSIX_C_SOURCE && _POSIX_C_SOURCE >= 199506L
#define BEAMTICK_POSIX
#endif

#ifdef BEAMTICK_POSIX
static inline void GetLocalTime(SYSTEMTIME *local)
{
    struct timespec now;
    struct tm parts;
    clock_gettime(CLOCK_REALTIME, &now);
    localtime_r(&now.tv_sec, &parts);
    local->wYear = (WORD)(parts.tm_year + 1900);
    local->wMonth = (WORD)(parts.tm_mon + 1);
    local->wDayOfWeek = (WORD)parts.tm_wday;
    local->wDay = (WORD)parts.tm_mday;
    local->wHour = (WORD)parts.tm_hour;
    local->wMinute = (WORD)parts.tm_min;
    local->wSecond = (WORD)parts.tm_sec;
    local->wMilliseconds = (WORD)(now.tv_nsec / 1000000);
}
#endif

/* ---- critical sections ---- */
typedef struct _CRITICAL_SECTION {
    HANDLE mutex;
} CRITICAL_SECTION, *LPCRITICAL_SECTION, *PCRITICAL_SECTION;

static inline void InitializeCriticalSection(CRITICAL_SECTION *section)
{
    section->mutex = beamtick_handle(beamtick_mutex_new(0));
}

static inline BOOL InitializeCriticalSectionAndSpinCount(CRITICAL_SECTION *section, DWORD spins)
{
    (void)spins;
    InitializeCriticalSection(section);
    return TRUE;
}

static inline void EnterCriticalSection(CRITICAL_SECTION *section)
{
    WaitForSingleObject(section->mutex, INFINITE);
}

static inline BOOL TryEnterCriticalSection(CRITICAL_SECTION *section)
{
    return WaitForSingleObject(section->mutex, 0) == WAIT_OBJECT_0;
}

static inline void LeaveCriticalSection(CRITICAL_SECTION *section)
{
    beamtick_mutex_release(beamtick_number(section->mutex));
}

static inline void DeleteCriticalSection(CRITICAL_SECTION *section)
{
    CloseHandle(section->mutex);
    section->mutex = NULL;
}

/* ---- one value among threads ---- */
#define InterlockedIncrement(value) __sync_add_and_fetch((value), 1)
#define InterlockedDecrement(value) __sync_sub_and_fetch((value), 1)
#define InterlockedExchangeAdd(value, more) __sync_fetch_and_add((value), (more))
#define InterlockedExchange(value, with) __atomic_exchange_n((value), (with), __ATOMIC_SEQ_CST)
#define InterlockedCompareExchange(value, with, if_equal) __sync_val_compare_and_swap((value), (if_equal), (with))

/* ---- timers ---- */
typedef VOID (CALLBACK *WAITORTIMERCALLBACK)(PVOID parameter, BOOLEAN fired);
#define WT_EXECUTEDEFAULT 0
#define WT_EXECUTEINTIMERTHREAD 0x20
#define WT_EXECUTEONLYONCE 8

static inline BOOL CreateTimerQueueTimer(HANDLE *timer, HANDLE queue, WAITORTIMERCALLBACK callback, PVOID parameter,
                                         DWORD due, DWORD period, ULONG flags)
{
    (void)queue;
    (void)flags;
    *timer = beamtick_timer(due, period, NULL, callback, parameter, 0);
    return *timer != NULL;
}

static inline BOOL DeleteTimerQueueTimer(HANDLE queue, HANDLE timer, HANDLE completion)
{
    (void)queue;
    return beamtick_timer_end(timer, completion == INVALID_HANDLE_VALUE);
}

static inline HANDLE CreateTimerQueue(void) { return beamtick_handle(beamtick_event_new(1, 0)); }
static inline BOOL DeleteTimerQueue(HANDLE queue) { return CloseHandle(queue); }

/* ---- the console and the process ---- */
#define STD_INPUT_HANDLE ((DWORD)-10)
#define STD_OUTPUT_HANDLE ((DWORD)-11)
#define STD_ERROR_HANDLE ((DWORD)-12)
#define FOREGROUND_BLUE 1
#define FOREGROUND_GREEN 2
#define FOREGROUND_RED 4
#define FOREGROUND_INTENSITY 8
#define BACKGROUND_BLUE 0x10
#define BACKGROUND_GREEN 0x20
#define BACKGROUND_RED 0x40
#define BACKGROUND_INTENSITY 0x80

static inline HANDLE GetStdHandle(DWORD which) { return (HANDLE)which; }

/* Colours and places only at a terminal: nothing of them gets into a file. */
static inline BOOL SetConsoleTextAttribute(HANDLE console, WORD colours)
{
    static const int order[8] = {0, 4, 2, 6, 1, 5, 3, 7};
    (void)console;
    if (isatty(STDOUT_FILENO)) {
        printf("\033[%d;%dm", (colours & 8 ? 90 : 30) + order[colours & 7], (colours & 0x80 ? 100 : 40) + order[colours >> 4 & 7]);
        fflush(stdout);
    }
    return TRUE;
}

static inline BOOL SetConsoleCursorPosition(HANDLE console, COORD at)
{
    (void)console;
    if (isatty(STDOUT_FILENO)) {
        printf("\033[%d;%dH", at.Y + 1, at.X + 1);
        fflush(stdout);
    }
    return TRUE;
}

static inline BOOL SetConsoleTitleA(LPCSTR title) { (void)title; return TRUE; }
static inline BOOL SetConsoleOutputCP(UINT page) { (void)page; return TRUE; }
static inline BOOL SetConsoleCP(UINT page) { (void)page; return TRUE; }
static inline UINT GetConsoleOutputCP(void) { return 65001; }
#define SetConsoleTitle SetConsoleTitleA
#define CP_UTF8 65001

/* Ctrl-C. The handler runs in a thread of its own, so that it may call the library; where it returns FALSE the process
 * ends by exit, which closes what is open. Call it before threads are made. */
typedef BOOL (WINAPI *PHANDLER_ROUTINE)(DWORD event);
#define CTRL_C_EVENT 0
#define CTRL_BREAK_EVENT 1
#define CTRL_CLOSE_EVENT 2

#ifdef BEAMTICK_POSIX
static inline void *beamtick_console(void *handler)
{
    PHANDLER_ROUTINE routine;
    sigset_t signals;
    int signal;
    memcpy(&routine, &handler, sizeof routine);
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGHUP);
    for (;;) {
        if (sigwait(&signals, &signal) != 0) {
            return NULL;
        }
        if (routine == NULL) {
            if (signal == SIGINT) {
                continue;
            }
        } else if (routine(signal == SIGINT ? CTRL_C_EVENT : CTRL_CLOSE_EVENT)) {
            continue;
        }
        exit(128 + signal);
    }
}

static inline BOOL SetConsoleCtrlHandler(PHANDLER_ROUTINE handler, BOOL add)
{
    sigset_t signals;
    pthread_t thread;
    void *passed;
    if (!add) {
        return FALSE;
    }
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals, NULL);
    memcpy(&passed, &handler, sizeof passed);
    if (pthread_create(&thread, NULL, beamtick_console, passed) != 0) {
        return FALSE;
    }
    pthread_detach(thread);
    return TRUE;
}
#endif

static inline void OutputDebugStringA(LPCSTR text) { fputs(text, stderr); }
#define OutputDebugString OutputDebugStringA

#define MB_OK 0
#define MB_OKCANCEL 1
#define MB_YESNO 4
#define MB_ICONERROR 0x10
#define MB_ICONSTOP 0x10
#define MB_ICONQUESTION 0x20
#define MB_ICONWARNING 0x30
#define MB_ICONINFORMATION 0x40
#define IDOK 1
#define IDYES 6

/* Printed, and taken as read: with MB_YESNO yes, else OK. */
static inline int MessageBoxA(HWND owner, LPCSTR text, LPCSTR caption, UINT type)
{
    (void)owner;
    fprintf(stderr, "%s: %s\n", caption ? caption : "", text ? text : "");
    return (type & 0xf) == MB_YESNO ? IDYES : IDOK;
}
#define MessageBox MessageBoxA

static inline BOOL Beep(DWORD frequency, DWORD milliseconds) { (void)frequency; (void)milliseconds; return TRUE; }
static inline void ExitProcess(UINT code) { exit((int)code); }

#define ZeroMemory(address, size) memset((address), 0, (size))
#define FillMemory(address, size, byte) memset((address), (byte), (size))
#define CopyMemory(to, from, size) memcpy((to), (from), (size))

/* max and min: macros in C as there; in C++ functions, which leave std::max and std::min alone. */
#ifndef NOMINMAX
#ifdef __cplusplus
template <class A, class B> inline auto max(const A &a, const B &b) -> decltype(a < b ? b : a) { return a < b ? b : a; }
template <class A, class B> inline auto min(const A &a, const B &b) -> decltype(b < a ? b : a) { return b < a ? b : a; }
#else
#define max(a, b) ((a) > (b) ? (a) : (b))
#define min(a, b) ((a) < (b) ? (a) : (b))
#endif
#endif

#endif
