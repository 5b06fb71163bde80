#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "report/benchmark/race.h"
#include "report/own_methods.h"

/// SUNDIALS under this program's equations: CVODE (BDF with a dense Jacobian by differences, or Krylov's
/// method for more than 100 links; Adams), ARKODE (Fehlberg's explicit pair of 8th order).

namespace planar_chain::benchmarks {

namespace {

enum class Kind { bdf, adams, erk };
constexpr int mostDense = 100;  // links

class SundialsRun : public tools::Run {
 public:
  SundialsRun(const Contest& contest, double setting, Kind kind)
      : n_(contest.scene.chain.size()), end_(contest.end), kind_(kind), dynamics_(contest.scene) {
    SUNContext_Create(nullptr, &context_);
    y_ = N_VNew_Serial(dynamics_.size(), context_);
    N_VConst(0, y_);
    tools::readStart(contest.scene, N_VGetArrayPointer(y_), N_VGetArrayPointer(y_) + n_);
    enter();
    if (kind == Kind::erk) {
      memory_ = ERKStepCreate(slope, 0, y_, context_);
      ERKStepSetUserData(memory_, this);
      ERKStepSStolerances(memory_, setting, setting);
      ERKStepSetTableNum(memory_, ARKODE_FEHLBERG_13_7_8);
      ERKStepSetMaxNumSteps(memory_, 100'000'000);
      ERKStepSetErrFile(memory_, nullptr);
      ERKStepSetStopTime(memory_, until_);
      return;
    }
    memory_ = CVodeCreate(kind == Kind::bdf ? CV_BDF : CV_ADAMS, context_);
    CVodeInit(memory_, slope, 0, y_);
    CVodeSetErrFile(memory_, nullptr);
    CVodeSetUserData(memory_, this);
    CVodeSStolerances(memory_, setting, setting);
    CVodeSetMaxNumSteps(memory_, 100'000'000);
    CVodeSetStopTime(memory_, until_);
    if (kind == Kind::adams) {
      iteration_ = SUNNonlinSol_FixedPoint(y_, 0, context_);
      CVodeSetNonlinearSolver(memory_, iteration_);
      return;
    }
    if (n_ <= mostDense) {
      matrix_ = SUNDenseMatrix(dynamics_.size(), dynamics_.size(), context_);
      solver_ = SUNLinSol_Dense(y_, matrix_, context_);
    } else {
      solver_ = SUNLinSol_SPGMR(y_, SUN_PREC_NONE, 0, context_);
    }
    CVodeSetLinearSolver(memory_, solver_, matrix_);
  }
  ~SundialsRun() override {
    kind_ == Kind::erk ? ERKStepFree(&memory_) : CVodeFree(&memory_);
    if (solver_) SUNLinSolFree(solver_);
    if (matrix_) SUNMatDestroy(matrix_);
    if (iteration_) SUNNonlinSolFree(iteration_);
    N_VDestroy(y_);
    SUNContext_Free(&context_);
  }

  Progress step() override {
    const int status = kind_ == Kind::erk ? ERKStepEvolve(memory_, until_, y_, &t_, ARK_ONE_STEP)
                                          : CVode(memory_, until_, y_, &t_, CV_ONE_STEP);
    if (status < 0) return Progress::refused;
    if (!std::isfinite(N_VGetArrayPointer(y_)[n_ - 1])) return Progress::diverged;
    if (t_ >= end_) return Progress::arrived;
    if (t_ >= until_) {
      enter();
      if (kind_ == Kind::erk) {
        ERKStepReInit(memory_, slope, t_, y_);
        ERKStepSetStopTime(memory_, until_);
      } else {
        CVodeReInit(memory_, t_, y_);
        CVodeSetStopTime(memory_, until_);
      }
    }
    return Progress::underway;
  }
  tools::Counts counts() const override {
    long steps = 0, failed = 0;
    if (kind_ == Kind::erk) {
      ERKStepGetNumSteps(memory_, &steps);
      ERKStepGetNumErrTestFails(memory_, &failed);
    } else {
      CVodeGetNumSteps(memory_, &steps);
      CVodeGetNumErrTestFails(memory_, &failed);
    }
    return {dynamics_.evaluations(), steps, failed};
  }
  void read(double* theta, double* omega) const override {
    std::copy_n(N_VGetArrayPointer(y_), n_, theta);
    std::copy_n(N_VGetArrayPointer(y_) + n_, n_, omega);
  }

 private:
  static int slope(realtype t, N_Vector y, N_Vector dydt, void* self) {
    static_cast<SundialsRun*>(self)->dynamics_.derivative(t, N_VGetArrayPointer(y), N_VGetArrayPointer(dydt));
    return 0;
  }
  void enter() {
    dynamics_.enter(t_);
    until_ = std::min(end_, dynamics_.effects().until());
  }

  int n_;
  double end_, until_ = 0, t_ = 0;
  Kind kind_;
  Dynamics dynamics_;
  SUNContext context_ = nullptr;
  N_Vector y_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
  SUNNonlinearSolver iteration_ = nullptr;
  void* memory_ = nullptr;
};

}  // namespace

Team sundialsTeam() {
  char version[32] = "";
  SUNDIALSGetVersion(version, sizeof version);
  const auto all = [](const Scene&) { return true; };
  return {"SUNDIALS",
          std::string(version) + " under this program's equations",
          {contestant<SundialsRun>("SUNDIALS", "CVODE BDF", false, all, Kind::bdf),
           contestant<SundialsRun>("SUNDIALS", "CVODE Adams", false, all, Kind::adams),
           contestant<SundialsRun>("SUNDIALS", "ARKODE Fehlberg 8(7)", false, all, Kind::erk)}};
}

}  // namespace planar_chain::benchmarks
