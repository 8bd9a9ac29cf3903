// Signal flag; see cli_signal.hpp.
#include "cases/program/cli_signal.hpp"

#include <array>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <ctime>

namespace talus::cli {
namespace {
volatile std::sig_atomic_t g_signal = 0, g_asked = 0, g_early = 0;
std::int64_t g_asked_at = 0;  ///< [ns]; the handler's own: its signals wait for each other
/// Within this time after the first a signal is the same wish: `timeout` signals a process and then its group.
constexpr std::int64_t k_one_wish = 100'000'000;  // [ns]
// SIGPIPE and SIGXFSZ come from the run's own writes, again with every further one.
constexpr std::array k_signals{SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ};
std::array<struct sigaction, k_signals.size()> g_former;

void remember(int number) {
  if (g_signal == 0) g_signal = number;
  if (number == SIGPIPE || number == SIGXFSZ) return;
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  const std::int64_t now = std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  // Whoever asks twice does not want to wait for the checkpoint: the default action follows when the handler returns.
  if (g_asked != 0 && now - g_asked_at > k_one_wish) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
  if (g_asked == 0) g_asked_at = now;
  g_asked = 1;
}

void remember_early(int number) {
  if (g_early == 0) g_early = number;
}
}  // namespace

void outlive_failed_writes() noexcept {
  struct sigaction action = {};
  action.sa_handler = remember_early;
  action.sa_flags = SA_RESTART;
  for (const int number : {SIGPIPE, SIGXFSZ}) sigaction(number, &action, nullptr);
}

SignalGuard::SignalGuard() {
  g_signal = g_early;
  g_asked = 0;
  struct sigaction action = {};
  action.sa_handler = remember;
  action.sa_flags = SA_RESTART;
  sigset_t ours;
  sigemptyset(&ours);
  for (const int number : k_signals) sigaddset(&action.sa_mask, number);
  for (std::size_t k = 0; k < k_signals.size(); ++k) {
    sigaction(k_signals[k], nullptr, &g_former[k]);
    sigaddset(&ours, k_signals[k]);
    if (k_signals[k] == SIGHUP && g_former[k].sa_handler == SIG_IGN) continue;
    sigaction(k_signals[k], &action, nullptr);
  }
  // A parent may have left them blocked: one that came meanwhile arrives here.
  pthread_sigmask(SIG_UNBLOCK, &ours, nullptr);
}

SignalGuard::~SignalGuard() {
  for (std::size_t k = 0; k < k_signals.size(); ++k) sigaction(k_signals[k], &g_former[k], nullptr);
}

int SignalGuard::caught() const noexcept { return g_signal; }

}  // namespace talus::cli
