// A simulator with a hull of its own, in surge, sway and yaw; the bank's force comes from narrows.
//   narrows export bank-force mikkelsen2025_dtc -o canal.h && g++ -std=c++11 host.cpp -o host && ./host
#include <cmath>
#include <cstdio>
#include "canal.h"

// Your ship as it is: a linear hull here. Replace it by your own.
struct Hull {
    double m_u = 260.0, m_v = 980.0, i_z = 960.0;         // masses with added masses [kg, kg m2]
    double y_v = 100.0, y_r = 118.0, n_v = 85.0, n_r = 590.0; // damping [kg/s, kg m/s, kg m2/s]
};

struct State {
    double x, y, psi, u, v, r; // SI and radians; y to starboard of the line
};

// The water abreast of the ship: what your chart says at x.
static canal_water water_at(double x) {
    canal_water water;
    water.starboard = x < 20.0 ? 3.5 : 3.2; // from the line to the foot of the bank [m]
    water.port = 3.5;
    water.slope_starboard = 0.0; // metres outward for each metre up; 0 of a wall
    water.slope_port = 0.0;
    water.depth = 0.3;
    return water;
}

static State rates(const Hull &hull, const State &s, bool banks) {
    double Y = -hull.y_v * s.v - hull.y_r * s.r, N = -hull.n_v * s.v - hull.n_r * s.r;
    if (banks) {
        const canal_water water = water_at(s.x);
        const canal_force bank = canal_bank_force(s.y, s.psi, s.u, &water); // the one line to add
        Y += bank.Y, N += bank.N;
    }
    const double c = std::cos(s.psi), sine = std::sin(s.psi);
    return {s.u * c - s.v * sine, s.u * sine + s.v * c, s.r, 0.0, Y / hull.m_v, N / hull.i_z};
}

static State moved(const State &s, const State &k, double h) {
    return {s.x + h * k.x, s.y + h * k.y, s.psi + h * k.psi, s.u + h * k.u, s.v + h * k.v, s.r + h * k.r};
}

int main() {
    const Hull hull;
    const double h = 0.05;
    for (int banks = 0; banks < 2; ++banks) {
        State s = {0.0, 0.8, 0.0, 1.0, 0.0, 0.0};
        for (int step = 0; step < 160; ++step) { // Runge-Kutta of order 2
            const State middle = moved(s, rates(hull, s, banks), h / 2);
            s = moved(s, rates(hull, middle, banks), h);
        }
        const canal_water water = water_at(s.x);
        const canal_force bank = canal_bank_force(s.y, s.psi, s.u, &water);
        std::printf("%s banks: y %.2f m, heading %.1f deg, beyond the tests %d\n", banks ? "with" : "without", s.y,
                    s.psi * 57.29577951308232, bank.beyond);
    }
    return 0;
}
