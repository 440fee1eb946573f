#pragma once

namespace saccade {

/// Velocity of a joint that approaches its reference approximately as a minimum-jerk movement of duration time_s:
/// velocity = F(s) (reference - position), F = a / (s^2 + c s + b).
///
/// With the joint as an integrator that is a triple pole at -5.322 / T. A step is half done after 0.50 T, 90 %
/// after 1.00 T, 99 % after 1.58 T, without overshoot; a ramp is followed 0.564 T late.
///
/// Called once per period, discretised by Tustin's rule; the caller holds the velocity until the next call. That would
/// delay the response by half a period, so the error is predicted for the middle of the coming period. Without this
/// prediction a step with T of 25 periods would be 99 % done after 1.38 T.
/// Source: iKinGazeCtrl's controller (constants a, b, c).
class MinimumJerkFilter {
 public:
  MinimumJerkFilter(double time_s, double period_s) : half_period_s_(period_s / 2) {
    const double per_s = 1.0 / time_s;
    const double a = 150.765868956161 * per_s * per_s * per_s;
    const double b = 84.9812819469538 * per_s * per_s;
    const double c = 15.9669610709384 * per_s;
    const double k = 2.0 / period_s;
    const double scale = 1.0 / (k * k + c * k + b);
    in_ = a * scale;
    back_1_ = (2.0 * b - 2.0 * k * k) * scale;
    back_2_ = (k * k - c * k + b) * scale;
  }

  /// Returns the velocity for the coming period. `reference_velocity`: velocity of the reference in that period; 0 for a
  /// reference that rests or jumps.
  double step(double reference, double reference_velocity, double position) {
    const double error = reference - position + half_period_s_ * (reference_velocity - velocity_);
    const double velocity =
        in_ * (error + 2.0 * error_ + error_before_) - back_1_ * velocity_ - back_2_ * velocity_before_;
    error_before_ = error_;
    error_ = error;
    velocity_before_ = velocity_;
    velocity_ = velocity;
    return velocity;
  }
  /// Resets the state of the filter to rest.
  void reset() { error_ = error_before_ = velocity_ = velocity_before_ = 0.0; }

 private:
  double half_period_s_;
  double in_, back_1_, back_2_;
  double error_ = 0.0, error_before_ = 0.0;
  double velocity_ = 0.0, velocity_before_ = 0.0;
};

}  // namespace saccade
