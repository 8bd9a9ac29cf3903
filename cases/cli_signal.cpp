// Signal flag; see cli_signal.hpp.
#include "cases/cli_signal.hpp"

#include <csignal>

namespace talus::cli {
namespace {
volatile std::sig_atomic_t g_signal = 0;
struct sigaction g_former_int, g_former_term;

void remember(int number) { g_signal = number; }
}  // namespace

SignalGuard::SignalGuard() {
  g_signal = 0;
  struct sigaction action = {};
  action.sa_handler = remember;
  sigemptyset(&action.sa_mask);
  // SA_RESETHAND: whoever asks twice does not want to wait for the checkpoint.
  action.sa_flags = SA_RESETHAND | SA_RESTART;
  sigaction(SIGINT, &action, &g_former_int);
  sigaction(SIGTERM, &action, &g_former_term);
}

SignalGuard::~SignalGuard() {
  sigaction(SIGINT, &g_former_int, nullptr);
  sigaction(SIGTERM, &g_former_term, nullptr);
}

int SignalGuard::caught() const noexcept { return g_signal; }

}  // namespace talus::cli
