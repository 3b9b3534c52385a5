/* conio.h for Linux: kbhit and getch. At a terminal they look at and take its keys, without waiting for the end of a
 * line. Without one they do what docs/c.md says: BEAMTICK_KEYS lists when keys are pressed. */
#ifndef BEAMTICK_CONIO_H
#define BEAMTICK_CONIO_H

#include <stdio.h>
#include <sys/select.h>
#include <termios.h>
#include <unistd.h>

#ifdef __cplusplus
extern "C" {
#endif
int beamtick_kbhit(void);
int beamtick_getch(void);
#ifdef __cplusplus
}
#endif

/* Looks for a key of the terminal (take 0), or takes one (take 1). */
static inline int beamtick_terminal(int take)
{
    struct termios before, raw;
    struct timeval now = {0, 0};
    fd_set keys;
    int found = 0;
    fflush(stdout);
    tcgetattr(STDIN_FILENO, &before);
    raw = before;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    tcsetattr(STDIN_FILENO, TCSANOW, &raw);
    if (take) {
        unsigned char key = 0;
        found = read(STDIN_FILENO, &key, 1) == 1 ? key : EOF;
    } else {
        FD_ZERO(&keys);
        FD_SET(STDIN_FILENO, &keys);
        found = select(STDIN_FILENO + 1, &keys, NULL, NULL, &now) > 0;
    }
    tcsetattr(STDIN_FILENO, TCSANOW, &before);
    return found;
}

static inline int kbhit(void)
{
    return isatty(STDIN_FILENO) ? beamtick_terminal(0) : beamtick_kbhit();
}

static inline int getch(void)
{
    return isatty(STDIN_FILENO) ? beamtick_terminal(1) : beamtick_getch();
}

static inline int getche(void)
{
    int key = getch();
    putchar(key);
    fflush(stdout);
    return key;
}

#define _kbhit kbhit
#define _getch getch
#define _getche getche
#define _putch putchar
#define putch putchar
#define _cputs(text) fputs((text), stdout)
#define cputs(text) fputs((text), stdout)
#define _cprintf printf
#define cprintf printf

#endif
