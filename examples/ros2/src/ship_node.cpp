// A ship between banks as a node of ROS 2.
//   narrows export c estimated_kcs -o src/ship.hpp && colcon build && ros2 run narrows_ship ship_node
//   ros2 topic pub /rudder_order std_msgs/msg/Float64 "{data: 0.05}"
// It hears /rudder_order [rad], positive to port, and publishes /odom, /clearance [m] and /beyond.
#include <chrono>
#include <cmath>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>
#include <std_msgs/msg/int32.hpp>
#include "vessel.hpp"

class ShipNode : public rclcpp::Node {
public:
    ShipNode()
        : Node("ship"), period_(declare_parameter("period", 0.1)), step_(declare_parameter("step", 0.05)),
          vessel_(declare_parameter("y", 0.0), declare_parameter("u", 3.0)) {
        odometry_ = create_publisher<nav_msgs::msg::Odometry>("odom", 10);
        clearance_ = create_publisher<std_msgs::msg::Float64MultiArray>("clearance", 10);
        beyond_ = create_publisher<std_msgs::msg::Int32>("beyond", 10);
        order_ = create_subscription<std_msgs::msg::Float64>(
            "rudder_order", 10, [this](const std_msgs::msg::Float64 &order) { vessel_.order_rudder(order.data); });
        timer_ = create_wall_timer(std::chrono::duration<double>(period_), [this] { tick(); });
    }

private:
    void tick() {
        if (!vessel_.advance(period_, step_)) RCLCPP_WARN_ONCE(get_logger(), "the voyage has ended: the ship lies still");
        const Motion motion = vessel_.motion();
        nav_msgs::msg::Odometry odometry;
        odometry.header.stamp = now();
        odometry.header.frame_id = "canal";
        odometry.child_frame_id = "ship";
        odometry.pose.pose.position.x = motion.x;
        odometry.pose.pose.position.y = motion.y;
        odometry.pose.pose.orientation.z = std::sin(motion.yaw / 2);
        odometry.pose.pose.orientation.w = std::cos(motion.yaw / 2);
        odometry.twist.twist.linear.x = motion.u;
        odometry.twist.twist.linear.y = motion.v;
        odometry.twist.twist.angular.z = motion.r;
        odometry_->publish(odometry);
        std_msgs::msg::Float64MultiArray clearance;
        clearance.data = {vessel_.port(), vessel_.starboard()};
        clearance_->publish(clearance);
        std_msgs::msg::Int32 beyond;
        beyond.data = vessel_.beyond();
        beyond_->publish(beyond);
    }

    double period_, step_;
    Vessel vessel_;
    rclcpp::Publisher<nav_msgs::msg::Odometry>::SharedPtr odometry_;
    rclcpp::Publisher<std_msgs::msg::Float64MultiArray>::SharedPtr clearance_;
    rclcpp::Publisher<std_msgs::msg::Int32>::SharedPtr beyond_;
    rclcpp::Subscription<std_msgs::msg::Float64>::SharedPtr order_;
    rclcpp::TimerBase::SharedPtr timer_;
};

int main(int count, char **values) {
    rclcpp::init(count, values);
    rclcpp::spin(std::make_shared<ShipNode>());
    rclcpp::shutdown();
    return 0;
}
