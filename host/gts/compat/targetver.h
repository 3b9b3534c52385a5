/* targetver.h for Linux: nothing. */
