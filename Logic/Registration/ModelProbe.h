#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "Registration/ModelUpdate.h"

namespace kerf {

struct ModelProbeOptions {
  double step_mm = 2.5;             ///< how much longer a cut is tried, and again while it helps
  int most_steps = 4;               ///< as often at most
  double step_deg = 8.0;            ///< how much its S is tried turned, and again while it helps
  double steepest_deg = 32.0;       ///< from the line of sight
  double unexplained_mm = 0.2;      ///< residual of the grips below which nothing is tried
  double hopeless_mm = 2.5;         ///< nor above
  double nonlinear_strain2 = 0.25;  ///< nor where the law is not believed
  double telling_mm = 0.08;         ///< residual from which the length of the held parts shows
  double regrip_gain = 0.15;
  double regrip_strain2 = 0.03;  ///< above, the law's error would be put down to them
  double gain = 0.04;            ///< of the cost that another cut has to save
  int steps = 4;                 ///< of the fit, for either side of the comparison
};

/// What is tried instead of a cut, or of the held parts.
struct ModelChange {
  int cut = 0;
  ModelCut instead;
  /// Redrawn: or several of the others together.
  enum class By { Longer, Shorter, Redrawn, Turned, Regripped } by = By::Longer;
  bool at_end = false;  ///< longer or shorter: at the last point of its line, or at the first
  std::array<double, 2> shorter_mm{};  ///< at its first and last end
};

/// A change that lets the organ under its grips follow the tracks better.
struct BetterModel : ModelChange {
  std::shared_ptr<const RegistrationState> then;  ///< what it is better than
  CutModel model;  ///< cut anew along it and all others, solvers included; none: other held parts
  GripFit fitted;  ///< and the grips under it; other held parts
};

/// Whether the model has been cut.
bool IsCut(const RegistrationState& state);

/// Whether the residual of the grips says that a cut may be wrong, and a cut is there that neither
/// a surgeon drew nor decides about; or, before any cut, that it may tell how long the held parts
/// are.
bool WorthProbing(const MethodOptions& options, const ModelProbeOptions& probe,
                  const RegistrationState& state);

/// The residual of the grips tells a cut that is too short or too long, or leads into the depth in
/// a wrong direction, from the right one (Registration/GripFit.h). Tries on copies: its line as all
/// evidence draws it now, and longer or shorter at each end that lies inside the organ; or turned
/// about its line either way (state.probing says which). What is better is gone on from. Every
/// candidate is cut anew; one that leaves a thread of tissue across S (Cutting/Bridges.h) gives way
/// to one that is turned by a degree, and a model that has one is itself cut anew.
/// @return the best, if it is better enough
/// @param given_up looked at between two trials
std::optional<BetterModel> ProbeModel(const std::vector<char>& usable, const CameraModel& camera,
                                      const MethodOptions& options, const ModelProbeOptions& probe,
                                      std::shared_ptr<const RegistrationState> state,
                                      const std::atomic<bool>* given_up = nullptr);

}  // namespace kerf
