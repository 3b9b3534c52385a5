// A C# program as they are written for such controllers, on gts.cs and libgts32.
using System;
using System.Runtime.InteropServices;
using System.Text;
using System.Threading;
using gts;

static class Program
{
    static void Check(string call, short code)
    {
        if (code == 0)
            return;
        StringBuilder why = new StringBuilder(256);
        mc.GT_GetLastReason(why, 256);
        Console.WriteLine("{0} = {1}: {2}", call, code, why);
        Environment.Exit(1);
    }

    // A value between two that no call may touch: what the library writes has 32 bits.
    class Guarded
    {
        const int Mark = 0x5A5A5A5A;
        int before = Mark;
        public int value;
        int after = Mark;
        public bool Whole { get { return before == Mark && after == Mark; } }
    }

    class GuardedU
    {
        const int Mark = 0x5A5A5A5A;
        int before = Mark;
        public uint value;
        int after = Mark;
        public bool Whole { get { return before == Mark && after == Mark; } }
    }

    // An axis in gear, edges of an input and an output for a time.
    static bool Gear()
    {
        Guarded even = new Guarded(), slave = new Guarded(), slope = new Guarded(), levels = new Guarded();
        GuardedU edges = new GuardedU();
        Check("GT_AxisOn", mc.GT_AxisOn(4));
        Check("GT_PrfGear", mc.GT_PrfGear(4));
        Check("GT_SetGearMaster", mc.GT_SetGearMaster(4, 5));
        Check("GT_SetGearRatio", mc.GT_SetGearRatio(4, -2147483647, 7, 100000));
        Check("GT_GetGearRatio", mc.GT_GetGearRatio(4, out even.value, out slave.value, out slope.value));
        short master, type, item;
        Check("GT_GetGearMaster", mc.GT_GetGearMaster(4, out master, out type, out item));
        Check("GT_GearStart", mc.GT_GearStart(8));
        uint from = 100;
        Check("GT_SetDiReverseCount", mc.GT_SetDiReverseCount(4, 1, ref from, 1));
        Check("GT_SimInput", mc.GT_SimInput(4, 1, 1));
        Thread.Sleep(5);
        Check("GT_GetDiReverseCount", mc.GT_GetDiReverseCount(4, 1, out edges.value, 1));
        Check("GT_SetDoBitReverse", mc.GT_SetDoBitReverse(12, 1, 1, 32767));
        Check("GT_GetDo", mc.GT_GetDo(12, out levels.value));
        return even.Whole && slave.Whole && slope.Whole && levels.Whole && edges.Whole && even.value == -2147483647
            && slave.value == 7 && slope.value == 100000 && edges.value == 101 && master == 5 && type == 2 && levels.value == 1;
    }

    static int Main()
    {
        if (Marshal.SizeOf(typeof(mc.TCrdPrm)) != mc.TCrdPrm.Size || Marshal.SizeOf(typeof(mc.TCrdData)) != 200
            || Marshal.SizeOf(typeof(mc.TPid)) != mc.TPid.Size || mc.TTrapPrm.Size != 32)
            return 2;
        Check("GT_Open", mc.GT_Open());
        IntPtr version;
        Check("GT_GetVersion", mc.GT_GetVersion(out version));
        if (!Marshal.PtrToStringAnsi(version).Contains("long of 32 bits"))
            return 3;
        Check("GT_AxisOn", mc.GT_AxisOn(1));
        Check("GT_AxisOn", mc.GT_AxisOn(2));
        Check("GT_PrfTrap", mc.GT_PrfTrap(1));
        mc.TTrapPrm trap;
        Check("GT_GetTrapPrm", mc.GT_GetTrapPrm(1, out trap));
        trap.acc = 1;
        trap.dec = 1;
        Check("GT_SetTrapPrm", mc.GT_SetTrapPrm(1, ref trap));
        Check("GT_SetPos", mc.GT_SetPos(1, -70000));
        Check("GT_SetVel", mc.GT_SetVel(1, 200));
        Check("GT_Update", mc.GT_Update(1));
        int status;
        uint clock;
        do
        {
            Check("GT_GetSts", mc.GT_GetSts(1, out status, 1, out clock));
        } while ((status & 0x400) != 0);
        double position;
        Check("GT_GetPrfPos", mc.GT_GetPrfPos(1, out position, 1, out clock));
        double[] all = new double[8];
        Check("GT_GetPrfPos", mc.GT_GetPrfPos(1, all, 8));

        mc.TCrdPrm crd = new mc.TCrdPrm();
        crd.profile = new short[8];
        crd.originPos = new int[8];
        crd.dimension = 2;
        crd.synVelMax = 300;
        crd.synAccMax = 2;
        crd.profile[0] = 1;
        crd.profile[1] = 2;
        crd.setOriginFlag = 1;
        crd.originPos[0] = -70000;
        Check("GT_SetCrdPrm", mc.GT_SetCrdPrm(1, ref crd));
        Check("GT_CrdClear", mc.GT_CrdClear(1));
        Check("GT_LnXY", mc.GT_LnXY(1, 4000, 3000, 100, 1));
        Check("GT_CrdStart", mc.GT_CrdStart(1, 0));
        short run;
        int segment;
        do
        {
            Check("GT_CrdStatus", mc.GT_CrdStatus(1, out run, out segment));
        } while (run != 0);
        double[] xy = new double[4];
        Check("GT_GetCrdPos", mc.GT_GetCrdPos(1, xy));
        double[] t = { 0, 100, 200 }, p = { 0, 500, 1000 }, v = { 0, 7.5, 0 };
        Check("GT_PrfPvt", mc.GT_PrfPvt(3));
        Check("GT_PvtTable", mc.GT_PvtTable(1, 3, t, p, v));
        short refused = mc.GT_GetPrfPos(99, out position, 1, out clock);
        Console.WriteLine("{0} {1} {2} at {3},{4} {5}", all[0], all[7], segment, xy[0], xy[1], refused);
        if (!Gear())
            return 4;
        Check("GT_Close", mc.GT_Close());
        Console.WriteLine("all checks passed");
        return 0;
    }
}
