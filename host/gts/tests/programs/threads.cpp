// Two threads at once, on one controller and on two: no call is refused for that, and each keeps its own reasons.
#include "gts.h"
#include "check.h"
#include <atomic>
#include <chrono>
#include <conio.h>
#include <thread>
#include <windows.h>

static std::atomic<int> wrong(0);

static void work(short axis, int turns)
{
    double pos;
    char reason[256], named[32];
    snprintf(named, sizeof named, "axis is %d", 100 + axis);
    for (int n = 1; n <= turns; n++) {
        wrong += GT_SetPrfPos(axis, n) != 0;
        wrong += GT_GetPrfPos(axis, &pos) != 0 || pos != n;
        wrong += GT_AxisOn((short)(100 + axis)) != 7;
        wrong += GT_GetLastReason(reason, sizeof reason) != 0 || strstr(reason, named) == NULL;
    }
}

static void stream(short axis)
{
    for (int n = 1; n <= 500; n++) {
        wrong += GT_PtData(axis, n, n) != 0;
    }
}

// What waits in the controller's time gets to its end though the controller is closed, and opened again, meanwhile.
static void close_while(const char *what, void (*wait)())
{
    using namespace std::chrono;
    DONE(GT_Open());
    std::atomic<bool> over(false);
    std::thread waiting([&] {
        wait();
        over = true;
    });
    std::this_thread::sleep_for(milliseconds(50));
    DONE(GT_Close());
    DONE(GT_Open());
    std::this_thread::sleep_for(milliseconds(50));
    DONE(GT_Close());
    auto end = steady_clock::now() + seconds(10);
    while (!over && steady_clock::now() < end) {
        std::this_thread::sleep_for(milliseconds(1));
    }
    if (!over) {
        printf("%s does not return\n", what);
        fflush(stdout);
        _Exit(1);
    }
    waiting.join();
}

static void sleep_long()
{
    Sleep(2000);
}

static void wait_for_a_key()
{
    beamtick_getch();
}

int main()
{
    DONE(GT_Open());
    std::thread first(work, 1, 200), second(work, 2, 200);
    first.join();
    second.join();
    HOLDS(wrong == 0);
    for (short axis = 1; axis <= 2; axis++) {
        DONE(GT_PrfPt(axis));
        DONE(GT_SetPtMemory(axis, 1));
        DONE(GT_PtClear(axis));
    }
    std::thread third(stream, 1), fourth(stream, 2);
    third.join();
    fourth.join();
    HOLDS(wrong == 0);
    short space;
    for (short axis = 1; axis <= 2; axis++) {
        DONE(GT_PtSpace(axis, &space));
        HOLDS(space == 524);
    }
    // Opened and closed while another thread calls: only the codes of both are seen.
    std::atomic<bool> end(false);
    std::thread fifth([&] {
        while (!end) {
            double pos;
            short code = GT_GetPrfPos(1, &pos);
            wrong += code != 0 && code != -7;
        }
    });
    for (int n = 0; n < 20; n++) {
        DONE(GT_Close());
        DONE(GT_Open());
    }
    end = true;
    fifth.join();
    HOLDS(wrong == 0);
    DONE(GT_Close());
    close_while("Sleep", sleep_long);
    setenv("BEAMTICK_KEYS", "2000", 1);
    close_while("getch", wait_for_a_key);
    return verdict();
}
