// Runs the program; see cli_runner.hpp.
#include "tests/cli/cli_runner.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace talus::test {
namespace fs = std::filesystem;
namespace {
std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
}  // namespace

Table table_of(const std::string& csv) {
  Table table;
  std::istringstream lines(csv);
  std::string line, word;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream words(line); std::getline(words, word, ',');) names.push_back(word);
  while (std::getline(lines, line)) {
    std::size_t column = 0;
    for (std::istringstream words(line); std::getline(words, word, ',');)
      table[names.at(column++)].push_back(std::stod(word));
  }
  return table;
}

Process::Process(const fs::path& folder, const std::vector<std::string>& arguments,
                 const std::function<void()>& prepare)
    : folder_(folder) {
  std::vector<std::string> words{TALUS_BINARY};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  const std::string out = folder / "stdout.log", err = folder / "stderr.log", directory = folder;
  id_ = fork();
  if (id_ < 0) throw std::runtime_error("fork failed");
  if (id_ != 0) return;
  const auto to = [](const std::string& path, int fd) {
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (file < 0 || dup2(file, fd) < 0) _exit(126);
  };
  to(out, 1);
  to(err, 2);
  if (chdir(directory.c_str()) != 0) _exit(126);
  if (prepare) prepare();
  execv(argv[0], argv.data());
  _exit(127);
}

Result Process::wait() {
  int status = 0;
  while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
  }
  Result r;
  r.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1 - WTERMSIG(status);
  r.out = content(folder_ / "stdout.log");
  r.err = content(folder_ / "stderr.log");
  return r;
}

void Cli::SetUp() {
  std::string pattern = fs::temp_directory_path() / "talus_cli_XXXXXX";
  ASSERT_NE(mkdtemp(pattern.data()), nullptr);
  folder = pattern;
}

void Cli::TearDown() { fs::remove_all(folder); }

std::string Cli::write(const std::string& name, const std::string& text) {
  std::ofstream(folder / name, std::ios::binary) << text;
  return name;
}

std::string Cli::read(const std::string& name) const { return content(folder / name); }

std::string Cli::json_value(const std::string& text, const std::string& key) {
  std::size_t at = text.find('"' + key + '"');
  if (at == std::string::npos) return {};
  at = text.find(':', at);
  at = text.find_first_not_of(" \t\n", at + 1);
  if (text[at] == '"') return text.substr(at + 1, text.find('"', at + 1) - at - 1);
  return text.substr(at, text.find_first_of(",}]\n", at) - at);
}

std::string small_scene(int number, const std::string& extra) {
  return R"(title = "small box"
seed = 3
gravity = [0, 0, -9.81]
sort_every = 150
[domain]
lower = [0, 0, 0]
upper = [0.1, 0.1, 0.2]
boundary = ["periodic", "periodic", "wall"]
[time]
step = 2e-5
steps = 400
[[material]]
name = "glass"
density = 2500
[contact]
model = "linear"
friction = 0.5
restitution = 0.8
normal_stiffness = 2e4
[[source]]
kind = "random"
number = )" +
         std::to_string(number) +
         R"(
material = "glass"
velocity_jitter = 1.0
region = { lower = [0.005, 0.005, 0.005], upper = [0.095, 0.095, 0.1] }
size = { kind = "uniform", min = 0.006, max = 0.009 }
[output]
particles_every = 1e-3
csv_every = 1e-4
)" + (extra.find("vtkhdf") == std::string::npos ? "vtkhdf = true\n" : "") +
         extra;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("test scene does not contain: " + from);
  return text.replace(at, from.size(), to);
}

}  // namespace talus::test
