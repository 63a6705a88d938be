#include <iostream>

#include "Commands.h"

namespace {

constexpr int kWrongUse = 2, kBadInput = 3, kCancelled = 130;

}  // namespace

int main(int argc, char** argv) {
  kerf::CommandContext context;
  CLI::App app{
      "Kerf: surgical augmented reality that survives the cut.\n"
      "Research software, not a medical device."};
  app.name("kerf");
  app.set_version_flag("--version", "kerf " KERF_VERSION " (" KERF_BASELINE ")");
  app.require_subcommand(1);
  app.fallthrough(false);
  kerf::AddPlanCommand(app, context);
  kerf::AddPhantomCommand(app, context);
  kerf::AddDemoCommand(app, context);
  kerf::AddReplayCommand(app, context);
  kerf::AddEvaluateCommand(app, context);
  kerf::AddExportCommand(app, context);
  kerf::AddValidateCommand(app, context);
  kerf::AddCalibrateCommand(app, context);
  kerf::AddAppCommand(app, context);
  kerf::InstallCancelHandler();

  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return kWrongUse;
  } catch (const kerf::Cancelled&) {
    context.progress.reset();
    std::cerr << "kerf: cancelled" << std::endl;
    return kCancelled;
  } catch (const kerf::UsageError& e) {
    context.progress.reset();
    std::cerr << "kerf: " << e.what() << std::endl;
    return kWrongUse;
  } catch (const kerf::InputError& e) {
    context.progress.reset();
    std::cerr << "kerf: " << e.what() << std::endl;
    return kBadInput;
  } catch (const std::exception& e) {
    context.progress.reset();
    std::cerr << "kerf: unexpected: " << e.what() << std::endl;
    return kBadInput;
  }
  context.progress.reset();
  if (context.json) std::cout << context.result.dump(1) << std::endl;
  return context.exit_status;
}
