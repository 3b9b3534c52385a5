// A console menu: numbers from the standard input, coloured lines, a clean end.
#include <iostream>
#include <iomanip>
#include <string>
#include <windows.h>
#include "gts.h"
using namespace std;

void Color(WORD c) { SetConsoleTextAttribute(GetStdHandle(STD_OUTPUT_HANDLE), c); }

bool Report(const char *name, short rtn)
{
    if (rtn == 0)
        return true;
    char why[256] = {0};
    GT_GetLastReason(why, 256);
    Color(FOREGROUND_RED | FOREGROUND_INTENSITY);
    cout << name << ": " << rtn << " " << why << endl;
    Color(FOREGROUND_RED | FOREGROUND_GREEN | FOREGROUND_BLUE);
    return false;
}

int main()
{
    SetConsoleTitle("GTS");
    SetConsoleOutputCP(CP_UTF8);
    if (!Report("GT_Open", GT_Open()))
    {
        MessageBox(NULL, TEXT("the card does not open"), TEXT("GTS"), MB_OK | MB_ICONERROR);
        return 1;
    }
    char *version = NULL;
    if (Report("GT_GetVersion", GT_GetVersion(&version)))
        cout << string(version).substr(0, 8) << endl;
    string word;
    while (cin >> word)
    {
        short axis = 0;
        if (word == "q")
            break;
        if (word == "on" && cin >> axis)
            Report("GT_AxisOn", GT_AxisOn(axis));
        else if (word == "move" && cin >> axis)
        {
            long pos;
            double vel;
            cin >> pos >> vel;
            if (!Report("GT_PrfTrap", GT_PrfTrap(axis)))
                continue;
            TTrapPrm t = {1, 1, 0, 0};
            GT_SetTrapPrm(axis, &t);
            GT_SetPos(axis, pos);
            GT_SetVel(axis, vel);
            if (Report("GT_Update", GT_Update(1 << (axis - 1))))
            {
                long sts = 0x400;
                while (sts & 0x400)
                {
                    Sleep(10);
                    GT_GetSts(axis, &sts);
                }
            }
        }
        else if (word == "pos")
        {
            double p[4];
            unsigned long clock;
            GT_GetPrfPos(1, p, 4, &clock);
            for (int i = 0; i < 4; i++)
                cout << setw(8) << fixed << setprecision(0) << p[i];
            cout << endl;
        }
        else
            cout << "? " << word << endl;
    }
    Report("GT_Close", GT_Close());
    return 0;
}
