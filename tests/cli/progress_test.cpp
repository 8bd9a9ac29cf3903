// The speed and the end that a progress line states, and signals that come twice.
#include "cases/program/progress.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "cases/program/cli_signal.hpp"
#include "scheduler/run/schedule.hpp"

namespace talus::cli {
namespace {

TEST(Pace, KnowsNothingBeforeTheFirstStep) {
  const Pace pace;
  EXPECT_EQ(pace.steps_per_s(), 0);
  EXPECT_EQ(pace.seconds_to(100), -1);
  EXPECT_EQ(duration_text(pace.seconds_to(100)), "?");
}

TEST(Pace, TheFirstStepsSayNothingOfTheEnd) {
  Pace pace;
  pace.note(0.2, 1000, 0);
  EXPECT_EQ(pace.seconds_to(2000), -1);
  pace.note(2, 2000, 0);
  EXPECT_EQ(pace.seconds_to(4000), 2);
  Pace slow;
  slow.note(20, 1, 0);
  EXPECT_EQ(slow.seconds_to(3), 40);
}

TEST(Pace, TheEndIsWhatIsLeftOverTheSpeed) {
  Pace pace;
  pace.note(4, 200, 6000);
  EXPECT_EQ(pace.steps_per_s(), 50);
  EXPECT_EQ(pace.work_per_s(), 1500);
  EXPECT_EQ(pace.seconds_to(1000), 16);  // 800 left at 50 per second
  EXPECT_EQ(pace.seconds_to(200), 0);
  EXPECT_EQ(pace.seconds_to(100), 0);
}

TEST(Pace, StepsBeforeTheFirstOneDoNotCount) {
  Pace pace(100);
  pace.note(2, 120, 20);
  EXPECT_EQ(pace.steps_per_s(), 10);
  EXPECT_EQ(pace.seconds_to(220), 10);
}

/// 10 steps per second for 40 s, then 100 per second: 20 s later nothing of the slow part counts.
TEST(Pace, FollowsTheRecentSpeed) {
  Pace pace;
  double steps = 0;
  for (int second = 1; second <= 40; ++second) pace.note(second, steps += 10, 0);
  EXPECT_EQ(pace.steps_per_s(), 10);
  for (int second = 41; second <= 65; ++second) pace.note(second, steps += 100, 0);
  EXPECT_EQ(pace.steps_per_s(), 100);
  EXPECT_EQ(pace.seconds_to(steps + 500), 5);
}

TEST(Pace, ALineShowsIt) {
  std::FILE* log = std::tmpfile();
  ASSERT_NE(log, nullptr);
  double before = 0, after = 0;
  {
    Progress progress(log, Progress::Style::lines, 100, 1100);
    while (progress.seconds() < 0.3) usleep(1000);
    before = progress.seconds();
    progress.update(350, 0.5, 10);  // a quarter is done: three times what it took is left
    after = progress.seconds();
  }
  std::rewind(log);
  char line[512] = "";
  ASSERT_NE(std::fgets(line, sizeof line, log), nullptr);
  std::fclose(log);
  const std::string text = line;
  const std::size_t at = text.find("ETA ");
  ASSERT_NE(at, std::string::npos) << text;
  if (after > 15) GTEST_SKIP() << "the machine stood still: the line is in minutes";
  const double eta = std::stod(text.substr(at + 4));
  EXPECT_GE(eta, 3 * before - 0.06) << text;
  EXPECT_LE(eta, 3 * after + 0.06) << text;
  EXPECT_NE(text.find(" 25.0 %"), std::string::npos) << text;
}

ProgressFacts facts() {
  ProgressFacts f;
  f.share = 0.4321;
  f.step = 432100;
  f.last = 1000000;
  f.time = 4.321;
  f.particles = 125000;
  f.work_per_s = 34.56e6;
  f.eta = 3725;
  return f;
}

TEST(TerminalLine, IsShorterThanTheTerminalIsWideAndSaysTheMostImportant) {
  ProgressFacts huge = facts();
  huge.step = huge.last = 1000000000000;
  huge.particles = 2000000000;
  huge.eta = 9e8;
  ProgressFacts unknown;
  for (int columns = 1; columns <= 200; ++columns)
    for (const ProgressFacts& f : {facts(), huge, unknown}) {
      const std::string line = terminal_line(f, columns);
      EXPECT_LT(static_cast<int>(line.size()), std::max(columns, 1)) << line;
      if (columns >= 9) {
        EXPECT_NE(line.find(" %"), std::string::npos) << columns << line;
      }
    }
  EXPECT_EQ(terminal_line(facts(), 20), " 43.2 % ETA 1:02:05");
  EXPECT_EQ(terminal_line(facts(), 40), " 43.2 %  34.56 M/s  ETA 1:02:05");
  const std::string wide = terminal_line(facts(), 200);
  for (const char* part : {" 43.2 %", "step  432100/1000000", "t = 4.321 s", "125000 particles",
                           "34.56 M particle-steps/s", "ETA 1:02:05", "[##########..............]"})
    EXPECT_NE(wide.find(part), std::string::npos) << part << " in " << wide;
}

TEST(TerminalLine, KeepsItsLayoutWhileStepsGrow) {
  ProgressFacts early = facts();
  early.step = 7;
  EXPECT_EQ(terminal_line(early, 80).size(), terminal_line(facts(), 80).size());
}

TEST(TerminalColumns, ComeFromTheTerminalElseFromTheEnvironmentElseAreEighty) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  const int no_terminal = fileno(file);
  unsetenv("COLUMNS");
  EXPECT_EQ(terminal_columns(no_terminal), 80);
  setenv("COLUMNS", "57", 1);
  EXPECT_EQ(terminal_columns(no_terminal), 57);
  for (const char* bad : {"0", "-3", "many", "1e9", "99999999999", "57x", ""}) {
    setenv("COLUMNS", bad, 1);
    EXPECT_EQ(terminal_columns(no_terminal), 80) << bad;
  }
  unsetenv("COLUMNS");
  std::fclose(file);
}

TEST(WallIntervalTest, IsDueAfterItsSecondsButNeverCostsMoreThanAFiftieth) {
  using Clock = WallInterval::Clock;
  const auto after = [start = Clock::now()](double seconds) {
    return start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  };
  WallInterval often(10);
  often.begin(after(0));
  often.done(after(0.1));
  EXPECT_FALSE(often.due(after(10.0)));
  EXPECT_TRUE(often.due(after(10.2)));
  often.begin(after(11));
  often.done(after(13));  // 2 s: the next one after 100 s
  EXPECT_FALSE(often.due(after(112)));
  EXPECT_TRUE(often.due(after(113.1)));
  const WallInterval never(0);
  EXPECT_FALSE(never.due(after(1e6)));
}

constexpr int k_later = -1;  ///< in place of a signal: a while without one

/// What becomes of a process that gets these signals while a SignalGuard lives; 0 if it lives on.
int fate(std::initializer_list<int> signals) {
  const pid_t child = fork();
  if (child == 0) {
    for (const int s : signals)
      if (s != k_later) signal(s, SIG_DFL);  // the tests may run under nohup, which ignores SIGHUP
    const SignalGuard guard;
    for (const int s : signals)
      if (s == k_later)
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
      else
        raise(s);
    _exit(guard.caught() == *signals.begin() ? 0 : 99);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
}

TEST(SignalGuard, RemembersTheFirstAndASecondEndsTheProcessAtOnce) {
  for (const int s : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(fate({s}), 0) << s;
    EXPECT_EQ(fate({s, k_later, s}), s);
  }
  EXPECT_EQ(fate({SIGINT, k_later, SIGTERM}), SIGTERM) << "a second one of any kind";
}

// timeout(1) signals the process, then its group.
TEST(SignalGuard, TheSameSignalTwiceAtATimeIsOneWish) {
  EXPECT_EQ(fate({SIGTERM, SIGTERM, SIGTERM}), 0);
  EXPECT_EQ(fate({SIGTERM, SIGTERM, k_later, SIGTERM}), SIGTERM);
}

TEST(SignalGuard, SignalsOfTheRunsOwnWritesMayComeAgain) {
  for (const int s : {SIGPIPE, SIGXFSZ}) {
    EXPECT_EQ(fate({s, s, s}), 0) << s;
    EXPECT_EQ(fate({s, s, SIGTERM}), 0) << "the first one of a user";
    EXPECT_EQ(fate({s, SIGTERM, k_later, SIGTERM}), SIGTERM);
  }
}

}  // namespace
}  // namespace talus::cli
