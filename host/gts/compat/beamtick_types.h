/* Types and constants of windows.h. */
#ifndef BEAMTICK_TYPES_H
#define BEAMTICK_TYPES_H

#define WINAPI
#define APIENTRY
#define CALLBACK
#define WINAPIV
#ifndef __stdcall
#define __stdcall
#endif
#ifndef __cdecl
#define __cdecl
#endif
#ifndef __fastcall
#define __fastcall
#endif
#define __declspec(what)
#define __forceinline inline
#ifndef __int64
#define __int64 long long
#endif
#define CONST const
#define VOID void
#define IN
#define OUT
#define TRUE 1
#define FALSE 0
#define MAX_PATH 260

typedef unsigned char BYTE, *PBYTE, *LPBYTE, UCHAR;
typedef unsigned char BOOLEAN;
typedef char CHAR, *PCHAR;
typedef short SHORT, *PSHORT;
typedef unsigned short WORD, USHORT, *PWORD, *LPWORD, *PUSHORT;
typedef int INT, *PINT, *LPINT;
typedef unsigned int UINT, *PUINT;
typedef long LONG, *PLONG, *LPLONG;
typedef unsigned long DWORD, ULONG, *PDWORD, *LPDWORD, *PULONG;
typedef long long LONGLONG, LONG64, INT64;
typedef unsigned long long ULONGLONG, DWORDLONG, DWORD64, UINT64;
typedef int INT32;
typedef unsigned int UINT32, DWORD32;
typedef int BOOL, *PBOOL, *LPBOOL;
typedef float FLOAT;
typedef double DOUBLE;
typedef size_t SIZE_T, DWORD_PTR, UINT_PTR, ULONG_PTR;
typedef ptrdiff_t INT_PTR, LONG_PTR;
typedef void *PVOID, *LPVOID, *HANDLE, *HWND, *HINSTANCE, *HMODULE;
typedef HANDLE *PHANDLE, *LPHANDLE;
typedef const void *LPCVOID;
typedef char *LPSTR, *PSTR;
typedef const char *LPCSTR, *PCSTR;
typedef char TCHAR, _TCHAR, *LPTSTR, *PTSTR;
typedef const char *LPCTSTR, *PCTSTR;
typedef wchar_t WCHAR, *LPWSTR;
typedef const wchar_t *LPCWSTR;
typedef size_t WPARAM;
typedef ptrdiff_t LPARAM, LRESULT;
typedef long HRESULT;

typedef union _LARGE_INTEGER {
    struct {
        unsigned int LowPart;
        int HighPart;
    } u;
    LONGLONG QuadPart;
} LARGE_INTEGER, *PLARGE_INTEGER;

typedef union _ULARGE_INTEGER {
    struct {
        unsigned int LowPart;
        unsigned int HighPart;
    } u;
    ULONGLONG QuadPart;
} ULARGE_INTEGER, *PULARGE_INTEGER;

typedef struct _SYSTEMTIME {
    WORD wYear, wMonth, wDayOfWeek, wDay, wHour, wMinute, wSecond, wMilliseconds;
} SYSTEMTIME, *PSYSTEMTIME, *LPSYSTEMTIME;

typedef struct _COORD {
    SHORT X, Y;
} COORD;

typedef struct _SECURITY_ATTRIBUTES {
    DWORD nLength;
    LPVOID lpSecurityDescriptor;
    BOOL bInheritHandle;
} SECURITY_ATTRIBUTES, *PSECURITY_ATTRIBUTES, *LPSECURITY_ATTRIBUTES;

#ifndef TEXT
#define TEXT(text) text
#endif
#define INVALID_HANDLE_VALUE ((HANDLE)(LONG_PTR)-1)
#define LOBYTE(word) ((BYTE)((DWORD)(word) & 0xff))
#define HIBYTE(word) ((BYTE)((DWORD)(word) >> 8 & 0xff))
#define LOWORD(value) ((WORD)((DWORD)(value) & 0xffff))
#define HIWORD(value) ((WORD)((DWORD)(value) >> 16 & 0xffff))
#define MAKEWORD(low, high) ((WORD)((BYTE)(low) | (WORD)(BYTE)(high) << 8))
#define MAKELONG(low, high) ((LONG)((WORD)(low) | (DWORD)(WORD)(high) << 16))
#define UNREFERENCED_PARAMETER(parameter) ((void)(parameter))

#endif
