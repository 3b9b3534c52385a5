/* tchar.h for Linux: texts of char. */
#ifndef BEAMTICK_TCHAR_H
#define BEAMTICK_TCHAR_H

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "beamtick_types.h"

#define _tmain main
#define _T(text) text
#define __T(text) text
#define _TEXT(text) text
#define _tprintf printf
#define _ftprintf fprintf
#define _stprintf sprintf
#define _sntprintf snprintf
#define _tscanf scanf
#define _stscanf sscanf
#define _fgetts fgets
#define _fputts fputs
#define _putts puts
#define _tcslen strlen
#define _tcscpy strcpy
#define _tcsncpy strncpy
#define _tcscat strcat
#define _tcscmp strcmp
#define _tcsncmp strncmp
#define _tcsicmp strcasecmp
#define _tcschr strchr
#define _tcsstr strstr
#define _tcstok strtok
#define _tcstol strtol
#define _tcstod strtod
#define _ttoi atoi
#define _ttol atol
#define _tstof atof
#define _tstoi atoi
#define _tfopen fopen
#define _tsystem system

#endif
