// What every C++ runner shares: arrays in and out, and the protocol on standard input and output, which is told in
// docs/adding-a-peer.md. A runner defines an engine and calls `peers::serve<Engine>`:
//
//     struct Engine {
//       using Pose = ...;                                     // a pose in the engine's own form, made before any clock runs
//       static bool has(peers::Mode);                         // whether it can answer this
//       static Pose pose(const peers::Matrix&);
//       Engine(const peers::Mesh& a, const peers::Mesh& b);   // builds its structures over both meshes: timed
//       void forget();                                        // drops what earlier poses left behind
//       double answer(peers::Mode, const Pose&);              // first, path: 0 or 1; all: pairs of triangles; distance: mm
//       std::size_t bytes() const;                            // memory held, 0 when unknown
//     };
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace peers {

enum class Mode { first, path, all, distance };

// Vertices in mm, in the part's own frame.
struct Mesh {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;
};

// Part b in the frame of part a: the upper three rows of the homogeneous matrix, mm.
using Matrix = std::array<std::array<double, 4>, 3>;

inline Mode mode_of(const std::string& name) {
  if (name == "first") return Mode::first;
  if (name == "path") return Mode::path;
  if (name == "all") return Mode::all;
  if (name == "distance") return Mode::distance;
  throw std::runtime_error("unknown mode " + name);
}

// ---- arrays: NPY, version 1.0, little endian, C order ----

template <class T> const char* descr() {
  if (std::is_same<T, double>::value) return "<f8";
  if (std::is_same<T, std::uint64_t>::value) return "<u8";
  if (std::is_same<T, std::uint32_t>::value) return "<u4";
  return "|u1";
}

// The rows of an array; Row is an array of numbers of type T, of any depth.
template <class T, class Row> std::vector<Row> read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.size() < 10 || bytes.compare(0, 8, std::string("\x93NUMPY\x01\x00", 8)) != 0)
    throw std::runtime_error(path + " is not an NPY file of version 1.0");
  const std::size_t start = 10 + static_cast<unsigned char>(bytes[8]) + 256 * static_cast<unsigned char>(bytes[9]);
  if (start > bytes.size() || bytes.substr(10, start - 10).find(descr<T>()) == std::string::npos)
    throw std::runtime_error(path + " does not hold numbers of type " + descr<T>());
  if ((bytes.size() - start) % sizeof(Row) != 0) throw std::runtime_error(path + " does not hold whole rows");
  std::vector<Row> rows((bytes.size() - start) / sizeof(Row));
  if (!rows.empty()) std::memcpy(rows.data(), bytes.data() + start, bytes.size() - start);
  return rows;
}

template <class T> void write(const std::string& path, const std::vector<T>& numbers, const std::string& shape) {
  std::string header = std::string("{'descr': '") + descr<T>() + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  header.append((64 - (10 + header.size() + 1) % 64) % 64, ' ');
  header += '\n';
  std::ofstream file(path, std::ios::binary);
  file.write("\x93NUMPY\x01\x00", 8);
  file.put(static_cast<char>(header.size() & 255));
  file.put(static_cast<char>(header.size() >> 8));
  file << header;
  file.write(reinterpret_cast<const char*>(numbers.data()), static_cast<std::streamsize>(numbers.size() * sizeof(T)));
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

inline Mesh read_mesh(const std::string& stem) {
  Mesh mesh;
  mesh.vertices = read<double, std::array<double, 3>>(stem + "_vertices.npy");
  mesh.faces = read<std::uint32_t, std::array<std::uint32_t, 3>>(stem + "_faces.npy");
  return mesh;
}

// ---- protocol ----

// Shortest time of a chunk that is worth keeping, ns: shorter ones are repeated.
constexpr std::uint64_t shortest_ns = 100000;

// A first pass longer than this, ns, is itself the measurement: what a cold start adds is lost in it.
constexpr std::uint64_t long_ns = 20000000;

template <class Work> std::uint64_t time_ns(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  const auto end = std::chrono::steady_clock::now();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(end - start).count());
}

template <class Engine> class Runner {
 public:
  Runner(Mode mode, const std::string& pair, const std::string& out, std::size_t rounds)
      : mode_(mode), out_(out), rounds_(rounds), a_(read_mesh(pair + "/a")), b_(read_mesh(pair + "/b")) {
    for (const Matrix& matrix : read<double, Matrix>(pair + "/poses.npy")) poses_.push_back(Engine::pose(matrix));
    answers_.resize(poses_.size());
    asked_.resize(poses_.size());
    ns_.resize(rounds * poses_.size());
    last_ns_.resize(poses_.size());
  }

  std::uint64_t build() {
    engine_.reset();
    return time_ns([&] { engine_.reset(new Engine(a_, b_)); });
  }

  std::uint64_t bytes() const { return engine_ ? engine_->bytes() : 0; }

  std::uint64_t chunk(std::size_t begin, std::size_t end) {
    if (begin >= end || end > poses_.size()) throw std::runtime_error("no such chunk");
    if (!engine_) build();
    const std::uint64_t once = std::max<std::uint64_t>(one_by_one(begin, end), 1);
    if (once >= long_ns) {
      keep(begin, end);
      return once;
    }
    const auto pass = [&] {
      engine_->forget();
      for (std::size_t i = begin; i < end; ++i) answers_[i] = engine_->answer(mode_, poses_[i]);
    };
    const std::uint64_t passes = once >= shortest_ns ? 1 : (shortest_ns + once - 1) / once;
    const std::uint64_t total = time_ns([&] {
      for (std::uint64_t k = 0; k < passes; ++k) pass();
    });
    one_by_one(begin, end);
    keep(begin, end);
    return total / passes;
  }

  void write_answers() const {
    std::vector<std::uint8_t> verdicts;
    for (const double answer : answers_) verdicts.push_back(mode_ == Mode::distance ? answer <= 0 : answer > 0);
    const std::string count = std::to_string(poses_.size());
    write(out_ + "/verdicts.npy", verdicts, count + ",");
    write(out_ + "/ns.npy", ns_, std::to_string(rounds_) + "," + count + ",");
    if (mode_ == Mode::all || mode_ == Mode::distance) write(out_ + "/values.npy", answers_, count + ",");
  }

 private:
  // Answers the poses, each timed alone; the sum of the times.
  std::uint64_t one_by_one(std::size_t begin, std::size_t end) {
    std::uint64_t sum = 0;
    engine_->forget();
    for (std::size_t i = begin; i < end; ++i) {
      last_ns_[i] = time_ns([&] { answers_[i] = engine_->answer(mode_, poses_[i]); });
      sum += last_ns_[i];
    }
    return sum;
  }

  // Keeps the times of the last pass one by one as those of the next round.
  void keep(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (asked_[i] < rounds_) ns_[asked_[i]++ * poses_.size() + i] = std::max<std::uint64_t>(last_ns_[i], 1);
  }

  Mode mode_;
  std::string out_;
  std::size_t rounds_;
  Mesh a_, b_;
  std::vector<typename Engine::Pose> poses_;
  std::unique_ptr<Engine> engine_;
  std::vector<double> answers_;
  std::vector<std::size_t> asked_;
  std::vector<std::uint64_t> ns_, last_ns_;
};

// Speaks the protocol; `arguments` are MODE PAIR OUT ROUNDS.
template <class Engine> int serve(const std::vector<std::string>& arguments) {
  try {
    if (arguments.size() != 4) throw std::runtime_error("expected MODE PAIR OUT ROUNDS");
    const Mode mode = mode_of(arguments[0]);
    if (!Engine::has(mode)) {
      std::cout << "unsupported" << std::endl;
      return 0;
    }
    Runner<Engine> runner(mode, arguments[1], arguments[2], std::stoul(arguments[3]));
    std::cout << "ready" << std::endl;
    std::string line;
    while (std::getline(std::cin, line)) {
      std::istringstream words(line);
      std::string command;
      std::size_t begin = 0, end = 0;
      words >> command;
      if (command == "build") {
        std::cout << "done " << runner.build() << std::endl;
      } else if (command == "bytes") {
        std::cout << "done " << runner.bytes() << std::endl;
      } else if (command == "chunk" && words >> begin >> end) {
        std::cout << "done " << runner.chunk(begin, end) << std::endl;
      } else if (command == "quit") {
        runner.write_answers();
        std::cout << "done 0" << std::endl;
        return 0;
      } else {
        throw std::runtime_error("unknown command " + line);
      }
    }
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << std::endl;
    std::cout << "error " << error.what() << std::endl;
    return 2;
  }
}

}  // namespace peers
