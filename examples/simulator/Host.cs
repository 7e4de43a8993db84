// A simulator with a hull of its own, in surge, sway and yaw; the bank's force comes from narrows.
//   narrows export bank-force mikkelsen2025_dtc -o canal.cs && mcs Host.cs canal.cs && mono Host.exe
// In Unity put both files into Assets, and call Bank once in FixedUpdate (y is to starboard of the canal's line).
using System;
using System.Globalization;

public struct State { public double x, y, psi, u, v, r; }

// Your ship as it is: a linear hull here. Replace it by your own.
public class Ship
{
    const double Mv = 980.0, Iz = 960.0;                       // masses with added masses [kg, kg m2]
    const double Yv = 100.0, Yr = 118.0, Nv = 85.0, Nr = 590.0; // damping [kg/s, kg m/s, kg m2/s]
    public State S = new State { y = 0.8, u = 1.0 };

    // The water abreast of the ship: what your chart says at x.
    static canal.Water WaterAt(double x)
    {
        return new canal.Water { starboard = x < 20.0 ? 3.5 : 3.2, port = 3.5, depth = 0.3 };
    }

    public static canal.Force Bank(State s)
    {
        return canal.BankForce(s.y, s.psi, s.u, WaterAt(s.x));
    }

    static State Rates(State s, bool banks)
    {
        double Y = -Yv * s.v - Yr * s.r, N = -Nv * s.v - Nr * s.r;
        if (banks) { var bank = Bank(s); Y += bank.Y; N += bank.N; } // the one line to add
        double c = Math.Cos(s.psi), sine = Math.Sin(s.psi);
        return new State { x = s.u * c - s.v * sine, y = s.u * sine + s.v * c, psi = s.r, v = Y / Mv, r = N / Iz };
    }

    static State Moved(State s, State k, double h)
    {
        return new State { x = s.x + h * k.x, y = s.y + h * k.y, psi = s.psi + h * k.psi,
                           u = s.u + h * k.u, v = s.v + h * k.v, r = s.r + h * k.r };
    }

    public void Step(double h, bool banks) // Runge-Kutta of order 2
    {
        S = Moved(S, Rates(Moved(S, Rates(S, banks), h / 2), banks), h);
    }
}

public static class Host
{
    public static void Main()
    {
        foreach (bool banks in new[] { false, true })
        {
            var ship = new Ship();
            for (int step = 0; step < 160; ++step) ship.Step(0.05, banks);
            Console.WriteLine(string.Format(CultureInfo.InvariantCulture,
                "{0} banks: y {1:F2} m, heading {2:F1} deg, beyond the tests {3}", banks ? "with" : "without",
                ship.S.y, ship.S.psi * 57.29577951308232, Ship.Bank(ship.S).beyond));
        }
    }
}
