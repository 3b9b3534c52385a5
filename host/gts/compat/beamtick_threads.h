/* Threads of windows.h and process.h on POSIX threads, and what they wait for, in libgts: so that waits last in the
 * program's time. A thread that is stopped (TerminateThread) ends at its next wait of this header. */
#ifndef BEAMTICK_THREADS_H
#define BEAMTICK_THREADS_H

#ifdef __cplusplus
extern "C" {
#endif
unsigned long long beamtick_now(void);
unsigned long beamtick_thread_new(int suspended);
void beamtick_thread_failed(unsigned long thread);
void beamtick_thread_begin(unsigned long thread);
void beamtick_thread_end(unsigned long thread, unsigned long code);
int beamtick_thread_resume(unsigned long thread);
int beamtick_thread_stop(unsigned long thread);
int beamtick_thread_is_stopped(unsigned long thread);
int beamtick_thread_code(unsigned long thread, unsigned long *code);
void beamtick_thread_sleep(unsigned long thread, unsigned long milliseconds);
unsigned long beamtick_event_new(int manual, int set);
int beamtick_event_set(unsigned long event, int to);
unsigned long beamtick_mutex_new(int owned);
int beamtick_mutex_release(unsigned long mutex);
unsigned long beamtick_semaphore_new(int count, int most);
int beamtick_semaphore_release(unsigned long semaphore, int more);
int beamtick_handle_close(unsigned long handle);
unsigned long beamtick_wait(unsigned long thread, const unsigned long *handles, unsigned count, int all,
                            unsigned long milliseconds);
#ifdef __cplusplus
}
#endif

#define INFINITE 0xffffffffUL
#define WAIT_OBJECT_0 0UL
#define WAIT_ABANDONED 0x80UL
#define WAIT_TIMEOUT 258UL
#define WAIT_FAILED 0xffffffffUL
#define STILL_ACTIVE 259UL
#define CREATE_SUSPENDED 4
#define MAXIMUM_WAIT_OBJECTS 64
#define THREAD_PRIORITY_IDLE (-15)
#define THREAD_PRIORITY_LOWEST (-2)
#define THREAD_PRIORITY_BELOW_NORMAL (-1)
#define THREAD_PRIORITY_NORMAL 0
#define THREAD_PRIORITY_ABOVE_NORMAL 1
#define THREAD_PRIORITY_HIGHEST 2
#define THREAD_PRIORITY_TIME_CRITICAL 15
#define NORMAL_PRIORITY_CLASS 0x20
#define HIGH_PRIORITY_CLASS 0x80
#define REALTIME_PRIORITY_CLASS 0x100

/* The calling thread's number here; 0 of one that was not made here. One variable for all files of a program. */
__attribute__((weak)) __thread unsigned long beamtick_thread_self;

static inline HANDLE beamtick_handle(unsigned long number) { return (HANDLE)number; }
static inline unsigned long beamtick_number(HANDLE handle) { return (unsigned long)handle; }

/* What a new thread gets. */
struct beamtick_start {
    unsigned long thread;
    unsigned (*ex)(void *);
    unsigned long (*windows)(void *);
    void (*plain)(void *);
    void *parameter;
};

static inline void beamtick_thread_exit(unsigned long code)
{
    if (beamtick_thread_self != 0) {
        beamtick_thread_end(beamtick_thread_self, code);
        beamtick_thread_self = 0;
    }
    pthread_exit(NULL);
}

/* Ends the calling thread if it was stopped. */
static inline void beamtick_thread_leave(void)
{
    if (beamtick_thread_self != 0 && beamtick_thread_is_stopped(beamtick_thread_self)) {
        beamtick_thread_exit(1);
    }
}

static inline void *beamtick_run(void *given)
{
    struct beamtick_start start = *(struct beamtick_start *)given;
    unsigned long code = 0;
    free(given);
    beamtick_thread_self = start.thread;
    beamtick_thread_begin(start.thread);
    beamtick_thread_leave();
    if (start.ex) {
        code = start.ex(start.parameter);
    } else if (start.windows) {
        code = start.windows(start.parameter);
    } else {
        start.plain(start.parameter);
    }
    beamtick_thread_end(start.thread, code & 0xffffffffUL);
    return NULL;
}

/* Makes a thread; its handle, or NULL. */
static inline HANDLE beamtick_thread(struct beamtick_start start, int suspended)
{
    pthread_t thread;
    struct beamtick_start *given = (struct beamtick_start *)malloc(sizeof *given);
    if (given == NULL) {
        return NULL;
    }
    start.thread = beamtick_thread_new(suspended);
    *given = start;
    if (pthread_create(&thread, NULL, beamtick_run, given) != 0) {
        beamtick_thread_failed(start.thread);
        free(given);
        return NULL;
    }
    pthread_detach(thread);
    return beamtick_handle(start.thread);
}

typedef DWORD (WINAPI *LPTHREAD_START_ROUTINE)(LPVOID parameter);
typedef LPTHREAD_START_ROUTINE PTHREAD_START_ROUTINE;

static inline BOOL CloseHandle(HANDLE handle) { return beamtick_handle_close(beamtick_number(handle)); }

static inline HANDLE CreateThread(SECURITY_ATTRIBUTES *security, SIZE_T stack, LPTHREAD_START_ROUTINE routine,
                                  LPVOID parameter, DWORD flags, LPDWORD id)
{
    struct beamtick_start start = {0, NULL, routine, NULL, parameter};
    HANDLE thread = beamtick_thread(start, (flags & CREATE_SUSPENDED) != 0);
    (void)security;
    (void)stack;
    if (id != NULL) {
        *id = (DWORD)beamtick_number(thread);
    }
    return thread;
}

static inline void ExitThread(DWORD code) { beamtick_thread_exit(code); }
static inline DWORD GetCurrentThreadId(void) { return beamtick_thread_self ? beamtick_thread_self : 0xfffffffeUL; }
static inline HANDLE GetCurrentThread(void) { return (HANDLE)-2L; }
static inline HANDLE GetCurrentProcess(void) { return (HANDLE)-1L; }
static inline DWORD GetCurrentProcessId(void) { return (DWORD)getpid(); }
/* A thread that runs cannot be suspended here; one that was made suspended is let go. */
static inline DWORD ResumeThread(HANDLE thread) { return (DWORD)(unsigned)beamtick_thread_resume(beamtick_number(thread)); }
static inline DWORD SuspendThread(HANDLE thread) { (void)thread; return 0xffffffffUL; }
static inline BOOL SetThreadPriority(HANDLE thread, int priority) { (void)thread; (void)priority; return TRUE; }
static inline BOOL SetPriorityClass(HANDLE process, DWORD priority) { (void)process; (void)priority; return TRUE; }
static inline DWORD_PTR SetThreadAffinityMask(HANDLE thread, DWORD_PTR mask) { (void)thread; return mask; }
static inline BOOL GetExitCodeThread(HANDLE thread, LPDWORD code) { return beamtick_thread_code(beamtick_number(thread), code); }
static inline BOOL TerminateThread(HANDLE thread, DWORD code) { (void)code; return beamtick_thread_stop(beamtick_number(thread)); }
static inline BOOL SwitchToThread(void) { return sched_yield() == 0; }

static inline DWORD WaitForMultipleObjects(DWORD count, const HANDLE *handles, BOOL all, DWORD milliseconds)
{
    unsigned long numbers[MAXIMUM_WAIT_OBJECTS];
    DWORD n, found;
    if (count == 0 || count > MAXIMUM_WAIT_OBJECTS) {
        return WAIT_FAILED;
    }
    for (n = 0; n < count; n++) {
        numbers[n] = beamtick_number(handles[n]);
    }
    found = beamtick_wait(beamtick_thread_self, numbers, (unsigned)count, all, milliseconds);
    beamtick_thread_leave();
    return found;
}

static inline DWORD WaitForSingleObject(HANDLE handle, DWORD milliseconds)
{
    return WaitForMultipleObjects(1, &handle, 0, milliseconds);
}

/* Names of events and mutexes are for one process here: each call makes a new one. */
static inline HANDLE CreateEventA(SECURITY_ATTRIBUTES *security, BOOL manual, BOOL set, LPCSTR name)
{
    (void)security;
    (void)name;
    return beamtick_handle(beamtick_event_new(manual, set));
}
#define CreateEvent CreateEventA
static inline BOOL SetEvent(HANDLE event) { return beamtick_event_set(beamtick_number(event), 1); }
static inline BOOL ResetEvent(HANDLE event) { return beamtick_event_set(beamtick_number(event), 0); }

static inline HANDLE CreateMutexA(SECURITY_ATTRIBUTES *security, BOOL owned, LPCSTR name)
{
    (void)security;
    (void)name;
    return beamtick_handle(beamtick_mutex_new(owned));
}
#define CreateMutex CreateMutexA
static inline BOOL ReleaseMutex(HANDLE mutex) { return beamtick_mutex_release(beamtick_number(mutex)); }

static inline HANDLE CreateSemaphoreA(SECURITY_ATTRIBUTES *security, LONG count, LONG most, LPCSTR name)
{
    (void)security;
    (void)name;
    return beamtick_handle(beamtick_semaphore_new((int)count, (int)most));
}
#define CreateSemaphore CreateSemaphoreA
static inline BOOL ReleaseSemaphore(HANDLE semaphore, LONG more, LONG *before)
{
    int had = beamtick_semaphore_release(beamtick_number(semaphore), (int)more);
    if (had >= 0 && before != NULL) {
        *before = had;
    }
    return had >= 0;
}

static inline DWORD GetLastError(void) { return 0; }
static inline void SetLastError(DWORD error) { (void)error; }

/* ---- timers: a thread each ---- */
struct beamtick_timer_start {
    unsigned long due, period;
    void (*multimedia)(UINT, UINT, DWORD_PTR, DWORD_PTR, DWORD_PTR);
    void (*queue)(PVOID, BOOLEAN);
    void *parameter;
    unsigned long event;
};

/* A timer that is ended while it calls ends after that call. */
static inline unsigned beamtick_timer_run(void *given)
{
    struct beamtick_timer_start start = *(struct beamtick_timer_start *)given;
    unsigned long long due = beamtick_now() + start.due * 1000000ULL;
    free(given);
    for (;;) {
        unsigned long long now = beamtick_now();
        if (now < due) {
            beamtick_thread_sleep(beamtick_thread_self, (unsigned long)((due - now + 999999u) / 1000000u));
        }
        beamtick_thread_leave();
        if (start.event) {
            beamtick_event_set(start.event, 1);
        } else if (start.multimedia) {
            start.multimedia((UINT)beamtick_thread_self, 0, (DWORD_PTR)start.parameter, 0, 0);
        } else {
            start.queue(start.parameter, 1);
        }
        if (start.period == 0) {
            return 0;
        }
        due += start.period * 1000000ULL;
    }
}

static inline HANDLE beamtick_timer(unsigned long due, unsigned long period,
                                    void (*multimedia)(UINT, UINT, DWORD_PTR, DWORD_PTR, DWORD_PTR),
                                    void (*queue)(PVOID, BOOLEAN), void *parameter, unsigned long event)
{
    struct beamtick_start start = {0, beamtick_timer_run, NULL, NULL, NULL};
    struct beamtick_timer_start *given = (struct beamtick_timer_start *)malloc(sizeof *given);
    HANDLE timer;
    if (given == NULL) {
        return NULL;
    }
    given->due = due;
    given->period = period;
    given->multimedia = multimedia;
    given->queue = queue;
    given->parameter = parameter;
    given->event = event;
    start.parameter = given;
    timer = beamtick_thread(start, 0);
    if (timer == NULL) {
        free(given);
    }
    return timer;
}

/* Ends a timer; `waits`: its last call has returned then. */
static inline BOOL beamtick_timer_end(HANDLE timer, BOOL waits)
{
    if (!beamtick_thread_stop(beamtick_number(timer))) {
        return FALSE;
    }
    if (waits && beamtick_number(timer) != beamtick_thread_self) {
        WaitForSingleObject(timer, INFINITE);
    }
    return CloseHandle(timer);
}

#endif
