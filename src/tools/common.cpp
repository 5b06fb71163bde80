#include "tools/common.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "reading/names.h"
#include "reading/section.h"
#include "scene/shipped_scenes.h"

namespace planar_chain::tools {

// ---- Arguments ---------------------------------------------------------------------------------

namespace po = boost::program_options;

std::optional<std::string> Arguments::text(const std::string& name) const {
  return count(name) != 0 ? std::optional(at(name).as<std::string>()) : std::nullopt;
}

std::optional<std::string> Arguments::file(const std::string& name) const {
  return text(name) == "-" ? std::nullopt : text(name);
}

double Arguments::number(const std::string& name, const char* expected, double low, double absent,
                         std::vector<Fault>& faults) const {
  const std::optional<std::string> given = text(name);
  if (!given) return absent;
  const std::optional<double> number = numberIn(*given);
  if (number && std::isfinite(*number) && *number > low) return *number;
  faults.push_back({"--" + name, expected, quoted(*given) + numberNote(*given)});
  return absent;
}

void checkAlone(const Arguments& given, const char* option, std::initializer_list<const char*> others,
                std::vector<Fault>& faults) {
  for (const char* other : others) {
    if (!given.has(option) || !given.has(other)) continue;
    faults.push_back({std::string("--") + option, std::string("no --") + other + " beside it", "both"});
  }
}

void finishOutput(const std::string& name) {
  errno = 0;
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw std::runtime_error("cannot write " + name + ": " + std::strerror(errno != 0 ? errno : EIO));
}

namespace {

constexpr const char* sceneInUsage =
    "[SCENE]\nSCENE: a YAML file (config/README.md explains it), a URDF, or the name of a scene that ships";
constexpr const char* urdfMeaning =
    "A URDF that is a planar chain, in place of the scene's chain and links; SCENE may add the rest";

Fault unknownOption(const std::string& given, const Tool& tool) {
  std::vector<std::string> names{"--help"};
  if (tool.hasScene) names.emplace_back("--urdf");
  for (const Option& option : tool.options) names.push_back(std::string("--") + option.name);
  return {onOneLine(given), orClosest(std::string("an option of ") + tool.name, given, names),
          "none of those that --help lists"};
}

/// Occupies the numbers of standard input, output and error if they are closed. Else a file of the run would
/// take the number, and with it the text that is meant for the other. Reading and writing there still fails.
void occupyStandardFiles() {
  for (int fd = 0; fd < 3; ++fd) {
    if (fcntl(fd, F_GETFD) < 0) open("/dev/null", fd == 0 ? O_WRONLY : O_RDONLY);
  }
}

}  // namespace

int run(const Tool& tool, int argc, char** argv) {
  occupyStandardFiles();
  std::signal(SIGXFSZ, SIG_IGN);  // a file at the limit of its size is an error in words
  try {
    constexpr unsigned width = 110;
    po::options_description options(std::string(tool.about) + "\nUsage: " + tool.name + " [OPTIONS] " +
                                        (tool.hasScene ? sceneInUsage : "") +
                                        "\nExit status: " + tool.exitStatus + "\n\nOptions",
                                    width);
    const auto text = [] { return po::value<std::string>()->value_name("TEXT"); };
    auto add = options.add_options()("help,h", "Print this help message and exit");
    if (tool.hasScene) add("urdf", text(), urdfMeaning);
    for (const Option& each : tool.options) {
      each.hasText ? add(each.name, text(), each.meaning) : add(each.name, each.meaning);
    }
    po::options_description all;
    all.add(options);
    po::positional_options_description positional;
    if (tool.hasScene) {
      all.add_options()("SCENE", text());
      positional.add("SCENE", 1);
    }
    const int style = po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
    Arguments given;
    po::store(po::command_line_parser(argc, argv).options(all).positional(positional).style(style).run(),
              given);
    if (given.has("help")) std::cout << options;
    const int status = given.has("help") ? done : tool.body(given);
    finishOutput();
    return status;
  } catch (const po::unknown_option& error) {
    std::cerr << toString(unknownOption(error.get_option_name(), tool)) << '\n';
    return badInput;
  } catch (const po::too_many_positional_options_error&) {
    const auto endsInComma = [](const std::string& each) { return !each.empty() && each.back() == ','; };
    std::cerr << (tool.hasScene ? "SCENE: expected one, got more" : "expected options alone, got")
              << " arguments without --"
              << (std::any_of(argv, argv + argc, endsInComma) ? " (no blank behind a comma: 0.1,0.2)\n"
                                                              : "\n");
    return badInput;
  } catch (const po::error& error) {
    std::cerr << error.what() << "\nRun with --help for more information.\n";
    return badInput;
  } catch (const Refused& refused) {
    std::cerr << refused.what() << '\n';
    return badInput;
  } catch (const std::bad_alloc&) {
    std::cerr << tool.name << ": there is not enough memory\n";
    return runFailed;
  } catch (const std::exception& error) {
    std::cerr << tool.name << ": " << error.what() << '\n';
    return runFailed;
  }
}

// ---- Scenes and files --------------------------------------------------------------------------

std::string loadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::array<char, 65536> part;
  while (text.size() <= longestYaml && (file.read(part.data(), part.size()) || file.gcount() > 0)) {
    text.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (text.size() > longestYaml) {
    throw Refused({{path, "at most " + std::to_string(longestYaml) + " bytes", "more"}});
  }
  if (!file.eof()) {
    throw Refused({{path, "a file that can be read", std::string("nothing: ") + std::strerror(errno)}});
  }
  return text;
}

std::string scenePath(const Arguments& given) {
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
  const auto scene = given.text("SCENE");
  return scene ? findScene(*scene, program.parent_path() / "../../share") : "";
}

void checkOutputs(const Arguments& given, const std::vector<std::string>& options,
                  const std::vector<std::string>& inputs, std::vector<Fault>& faults) {
  namespace fs = std::filesystem;
  std::error_code none;
  std::vector<fs::path> taken(inputs.begin(), inputs.end()), made;
  for (const std::string& option : options) {
    const std::optional<std::string> path = given.file(option);
    if (!path) continue;
    const bool isNew = !fs::exists(*path, none);
    // To open a pipe waits for its reader, and to close it ends what the reader gets.
    const bool isPipe = fs::is_fifo(*path, none);
    if (isPipe ? access(path->c_str(), W_OK) != 0 : !std::ofstream(*path, std::ios::app)) {
      const std::string why = std::strerror(errno);
      faults.push_back({"--" + option, "a file that can be written", quoted(*path) + ": " + why});
      continue;
    }
    // It exists now, so that one file is found under two names.
    const fs::path file = fs::canonical(*path, none);
    const auto isSame = [&](const fs::path& other) { return fs::equivalent(file, other, none); };
    if (fs::is_regular_file(file, none) && std::any_of(taken.begin(), taken.end(), isSame)) {
      faults.push_back({"--" + option, "a file that is not another of the run's", quoted(*path)});
    }
    taken.push_back(file);
    if (isNew) made.push_back(file);
  }
  for (const fs::path& file : made) fs::remove(file, none);
}

Scene readScene(const Arguments& given, const std::function<void(Value&)>& amend, std::vector<Fault> faults) {
  const auto file = given.text("SCENE"), urdf = given.text("urdf");
  try {
    if (!file && !urdf) throw Refused({{"SCENE", "a scene file, or --urdf with a robot", "neither"}});
    const std::string path = scenePath(given), pathOfUrdf = urdf.value_or(path);
    const std::string text = file ? loadText(path) : "{}";
    const std::string robot = urdf ? loadText(*urdf) : "";
    try {
      Value value = parseScene(text);
      if (urdf && value.map() && !value.map()->emplace("robot_description", robot).second) {
        throw Refused({{"robot_description", "nothing beside --urdf", "one in the scene"}});
      }
      amend(value);
      Scene scene = planar_chain::readScene(value);
      scene.text = toYaml(value);
      if (faults.empty()) {
        for (const Note& note : withFiles(scene.notes, path, pathOfUrdf)) {
          std::cerr << "note: " << toString(note) << '\n';
        }
        return scene;
      }
    } catch (const Refused& refused) {
      throw Refused(withFiles(refused.faults(), path, pathOfUrdf));
    }
  } catch (const Refused& refused) {
    faults.insert(faults.end(), refused.faults().begin(), refused.faults().end());
  }
  throw Refused(std::move(faults));
}

}  // namespace planar_chain::tools
