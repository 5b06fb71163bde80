#include "report/benchmark/race.h"
#include "report/benchmark/simbody_pins.h"

/// Simbody's integrators with error control, of the whole system; setting: their accuracy. CPodes is a
/// SUNDIALS of its own and takes the symbols of the one linked here for its own: the two cannot be in one
/// program.

namespace planar_chain::benchmarks {

namespace {

class SimbodyRun : public tools::Run {
 public:
  using Make = std::unique_ptr<SimTK::Integrator> (*)(const SimTK::System&);

  SimbodyRun(const Contest& contest, double setting, Make make)
      : coordinates_(contest.scene.chain.coordinates()),
        n_(coordinates_.size()),
        end_(contest.end),
        matter_(system_),
        forces_(system_) {
    const Chain& chain = contest.scene.chain;
    SimTK::Force::Gravity(forces_, matter_, SimTK::Vec3(chain.gravity().x, chain.gravity().y, 0));
    SimbodyPins pins(matter_);
    for (int i = 0; i < n_; ++i) {
      const Joint& joint = chain.joints()[static_cast<std::size_t>(i)];
      bodies_.push_back(pins.add(chain.links()[static_cast<std::size_t>(i)], joint));
      const auto coordinate = SimTK::MobilizerQIndex(0);
      if (joint.stiffness != 0) {
        SimTK::Force::MobilityLinearSpring(forces_, bodies_.back(), coordinate, joint.stiffness,
                                           joint.restAngle);
      }
      if (joint.damping != 0) {
        SimTK::Force::MobilityLinearDamper(forces_, bodies_.back(), SimTK::MobilizerUIndex(0), joint.damping);
      }
    }
    if (contest.scene.tip) hold(contest.scene);
    SimTK::State state = system_.realizeTopology();
    for (int i = 0; i < n_; ++i) {
      bodies_[static_cast<std::size_t>(i)].setOneQ(state, 0, contest.scene.q[static_cast<std::size_t>(i)]);
      bodies_[static_cast<std::size_t>(i)].setOneU(state, 0, contest.scene.qd[static_cast<std::size_t>(i)]);
    }
    integrator_ = make(system_);
    integrator_->setAccuracy(setting);
    integrator_->setFinalTime(end_);
    integrator_->setReturnEveryInternalStep(true);
    integrator_->initialize(state);
    before_ = system_.getNumRealizationsOfThisStage(SimTK::Stage::Acceleration);
  }

  Progress step() override {
    try {
      integrator_->stepTo(end_);
    } catch (const std::exception&) {
      return Progress::refused;
    }
    const SimTK::State& state = integrator_->getState();
    if (!std::isfinite(state.getQ()[n_ - 1])) return Progress::diverged;
    return state.getTime() >= end_ ? Progress::arrived : Progress::underway;
  }
  tools::Counts counts() const override {
    return {system_.getNumRealizationsOfThisStage(SimTK::Stage::Acceleration) - before_,
            integrator_->getNumStepsTaken(),
            integrator_->getNumStepsAttempted() - integrator_->getNumStepsTaken()};
  }
  void read(double* theta, double* omega) const override {
    const SimTK::State& state = integrator_->getState();
    for (int i = 0; i < n_; ++i) {
      theta[i] = bodies_[static_cast<std::size_t>(i)].getOneQ(state, 0);
      omega[i] = bodies_[static_cast<std::size_t>(i)].getOneU(state, 0);
    }
    coordinates_.toAbsolute(theta, theta);
    coordinates_.toAbsolute(omega, omega);
  }

 private:
  /// By a plane for each direction: a Ball's third condition would be that the motion is plane.
  void hold(const Scene& scene) {
    const Vec2d position = tipPosition(scene);
    const Link& last = scene.chain.links().back();
    const SimTK::Vec3 pin(last.pin.x - last.com.x, last.pin.y - last.com.y, 0);
    SimTK::Constraint::PointInPlane(matter_.updGround(), SimTK::XAxis, position.x, bodies_.back(), pin);
    SimTK::Constraint::PointInPlane(matter_.updGround(), SimTK::YAxis, position.y, bodies_.back(), pin);
  }

  Coordinates coordinates_;
  int n_;
  double end_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  std::vector<SimTK::MobilizedBody> bodies_;
  std::unique_ptr<SimTK::Integrator> integrator_;
  long long before_ = 0;
};

template <class Made>
Contestant with(const char* method) {
  const SimbodyRun::Make make = [](const SimTK::System& system) -> std::unique_ptr<SimTK::Integrator> {
    return std::make_unique<Made>(system);
  };
  const auto takes = [](const Scene& scene) {
    return hasFixedTip(scene) && scene.loads.empty() && scene.chain.size() <= 1000;
  };
  return contestant<SimbodyRun>("Simbody", method, false, takes, make);
}

}  // namespace

Team simbodyTeam() {
  int major, minor, build;
  SimTK_version_simbody(&major, &minor, &build);
  return {"Simbody",
          std::to_string(major) + "." + std::to_string(minor) + " (its error control)",
          {with<SimTK::RungeKuttaMersonIntegrator>("RK Merson"),
           with<SimTK::RungeKuttaFeldbergIntegrator>("RK Feldberg")}};
}

}  // namespace planar_chain::benchmarks
