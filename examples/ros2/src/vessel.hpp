// A ship of narrows in the axes of ROS (REP 103): x along the canal, y to port, angles counter-clockwise from above.
#pragma once
#include "ship.hpp" // narrows export c estimated_kcs -o src/ship.hpp

struct Motion {
    double x, y, yaw, u, v, r; // SI and radians; velocities ahead, to port, counter-clockwise
};

class Vessel {
public:
    Vessel(double y, double u) { ship_.y(-y), ship_.u(u); }

    // A positive order turns the bow to port.
    void order_rudder(double angle) { ship_.inputs.rudder_order = -angle; }

    // Sails for a duration [s] by steps [s]; false once the voyage has ended, at a bank or otherwise.
    bool advance(double duration, double step) {
        sails_ = sails_ && ship_.integrate(step, duration) == ship::Outcome::Afloat;
        return sails_;
    }

    Motion motion() const {
        const double moves = sails_ ? 1.0 : 0.0;
        return {ship_.x(), -ship_.y(), -ship_.psi(), moves * ship_.u(), -moves * ship_.v(), -moves * ship_.r()};
    }

    // Clearance to port and to starboard of the hull [m].
    double port() const { return ship_.clearance()[1]; }
    double starboard() const { return ship_.clearance()[0]; }

    // 0 where the model's tests covered the motion; else a sum of 1 speed, 2 offset, 4 heading, 8 yaw rate.
    int beyond() const { return ship_.beyond(); }

private:
    ship::Ship ship_;
    bool sails_ = true;
};
