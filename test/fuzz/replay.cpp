/// replay RUNS PATH…: runs the target of libFuzzer without libFuzzer. Every file of the paths goes in as it
/// is, then RUNS changed ones: bytes, words and pieces of other files put in, taken out, doubled. Every call
/// makes the same inputs. A failure is a crash; the file named by the last line then has the input.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;

/// What a reader may stumble over.
const std::vector<std::string> words{"nan",
                                     "-.inf",
                                     "1e999",
                                     "1e-320",
                                     "-0",
                                     "4294967296",
                                     "0x10",
                                     "~",
                                     "true",
                                     "&a ",
                                     "*a",
                                     "<<: ",
                                     "[",
                                     "{",
                                     "]",
                                     "}",
                                     "? ",
                                     ": ",
                                     "- ",
                                     ", ",
                                     "\"",
                                     "'",
                                     "---\n",
                                     "!!str ",
                                     "# ",
                                     "\t",
                                     "\n",
                                     "\n  ",
                                     std::string(1, '\0'),
                                     "\xff",
                                     "\xe2\x80\xa8",
                                     "repeat: 100000"};

class Mutations {
 public:
  explicit Mutations(const std::vector<std::string>& corpus) : corpus_(corpus) {}

  std::string next() {
    std::string text = corpus_[below(corpus_.size())];
    for (std::size_t k = 1 + below(4); k > 0; --k) change(text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return engine_() % n; }

  void change(std::string& text) {
    const std::size_t at = below(text.size() + 1);
    const std::size_t length = std::min(text.size() - at, below(40));
    const std::string& other = corpus_[below(corpus_.size())];
    switch (below(6)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(at, length));
        break;
      case 3:
        text.insert(at, words[below(words.size())]);
        break;
      case 4:
        text.replace(at, length, words[below(words.size())]);
        break;
      default:
        text.insert(at, other.substr(below(other.size() + 1), below(200)));
    }
  }

  const std::vector<std::string>& corpus_;
  std::mt19937 engine_{1};
};

void run(const std::string& input, const fs::path& kept) {
  std::ofstream(kept, std::ios::binary) << input;
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s RUNS PATH…\n", argv[0]);
    return 2;
  }
  std::vector<fs::path> files;
  for (int i = 2; i < argc; ++i) {
    for (const auto& entry : fs::directory_iterator(argv[i])) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no file to start from\n", argv[0]);
    return 2;
  }

  const fs::path kept = fs::absolute(fs::path(argv[0]).filename() += "_last_input");
  std::printf("a failing input is in %s\n", kept.c_str());
  std::fflush(stdout);
  for (const std::string& input : corpus) run(input, kept);
  Mutations mutations(corpus);
  const int runs = std::atoi(argv[1]);
  for (int k = 0; k < runs; ++k) run(mutations.next(), kept);
  fs::remove(kept);
  std::printf("%zu files and %d changed ones\n", corpus.size(), runs);
}
