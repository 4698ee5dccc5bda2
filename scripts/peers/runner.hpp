// What every C++ runner shares: arrays in and out, and the protocol on standard input and output, which is told in
// docs/adding-a-peer.md. A runner defines an engine and calls `peers::serve<Engine>`:
//
//     struct Engine {
//       using Pose = ...;                                     // a pose in the engine's own form, made before any clock runs
//       static bool has(peers::Mode);                         // whether it can answer this
//       static Pose pose(const peers::Matrix&);
//       Engine(const peers::Mesh& a, const peers::Mesh& b);   // builds its structures over both meshes: timed
//       void forget();                                        // drops what earlier poses left behind
//       double answer(peers::Mode, const Pose&);              // first, path: 0 or 1; all: pairs of triangles; distance: mm; never asked about batch
//       double motion(const peers::Motion&);                  // time of first contact, infinite without; without this function, an engine with distances advances by them
//       std::size_t bytes() const;                            // memory held, 0 when unknown
//     };
//
// In mode batch each thread has an engine of its own and asks it `first`: none needs to be safe for several threads.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <omp.h>

namespace peers {

enum class Mode { first, path, all, distance, batch, motion };

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
  if (name == "batch") return Mode::batch;
  if (name == "motion") return Mode::motion;
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

// ---- motions ----

// The origin of b goes straight and evenly, and b turns about it at a constant rate, the shorter way, by less than half a turn. Times are from 0 to 1.
struct Motion {
  Matrix start, end;
  std::array<double, 3> way{}, axis{};
  double angle = 0;

  Motion(const Matrix& from, const Matrix& to) : start(from), end(to) {
    double turn[3][3] = {};  // from the first rotation to the second, in the frame of a
    for (int i = 0; i < 3; ++i) {
      way[i] = to[i][3] - from[i][3];
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) turn[i][j] += to[i][k] * from[j][k];
    }
    const double x = turn[2][1] - turn[1][2], y = turn[0][2] - turn[2][0], z = turn[1][0] - turn[0][1];
    const double twice_sine = std::sqrt(x * x + y * y + z * z);
    angle = std::atan2(twice_sine, turn[0][0] + turn[1][1] + turn[2][2] - 1);
    if (twice_sine > 0) axis = {x / twice_sine, y / twice_sine, z / twice_sine};
  }

  Matrix at(double time) const {
    const double c = std::cos(angle * time), s = std::sin(angle * time), rest = 1 - c;
    const double x = axis[0], y = axis[1], z = axis[2];
    const double turn[3][3] = {{c + x * x * rest, x * y * rest - z * s, x * z * rest + y * s},
                               {y * x * rest + z * s, c + y * y * rest, y * z * rest - x * s},
                               {z * x * rest - y * s, z * y * rest + x * s, c + z * z * rest}};
    Matrix pose{};
    for (int i = 0; i < 3; ++i) {
      pose[i][3] = start[i][3] + way[i] * time;
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) pose[i][j] += turn[i][k] * start[k][j];
    }
    return pose;
  }

  // How far at most a point goes that is so far from the origin of b, mm per unit of time.
  double speed_mm(double reach_mm) const {
    return std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]) + angle * reach_mm;
  }
};

// Distance at which meshes count as touching, mm.
constexpr double contact_mm = 1e-4;

// Most steps of one motion. A motion that needs more counts as in contact at the last.
constexpr int most_steps = 1000000;

// Conservative advancement by an engine's distances, the loop of crates/harness/src/method/motion.rs.
template <class Engine> double advance(Engine& engine, const Motion& motion, double reach_mm) {
  const double speed_mm = motion.speed_mm(reach_mm);
  double time = 0;
  for (int i = 0; i < most_steps; ++i) {
    const double left_mm = speed_mm * (1 - time) + contact_mm;
    const double apart_mm = engine.answer(Mode::distance, Engine::pose(motion.at(time)));
    if (apart_mm <= contact_mm) return time;
    const double step = (apart_mm - 0.5 * contact_mm) / speed_mm;
    if (apart_mm >= left_mm || time + step >= 1) return std::numeric_limits<double>::infinity();
    time += step;
  }
  return time;
}

template <class Engine> auto first_contact(Engine& engine, const Motion& motion, double, int) -> decltype(engine.motion(motion)) {
  return engine.motion(motion);
}

template <class Engine> double first_contact(Engine& engine, const Motion& motion, double reach_mm, long) {
  return advance(engine, motion, reach_mm);
}

// ---- protocol ----

// Shortest time of a chunk that is worth keeping, ns: shorter ones are repeated.
constexpr std::uint64_t shortest_ns = 100000;

// A first pass longer than this, ns, is itself the measurement: what a cold start adds is lost in it.
constexpr std::uint64_t long_ns = 20000000;

// Poses that a thread takes at a time in mode batch.
constexpr int batch_poses = 64;

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
    if (mode == Mode::motion) {
      const auto starts = read<double, Matrix>(pair + "/poses.npy"), ends = read<double, Matrix>(pair + "/ends.npy");
      if (starts.size() != ends.size()) throw std::runtime_error("there are not as many ends as poses");
      for (std::size_t i = 0; i < starts.size(); ++i) motions_.emplace_back(starts[i], ends[i]);
      for (const auto& v : b_.vertices) reach_mm_ = std::max(reach_mm_, std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    }
    engines_.resize(mode == Mode::batch ? omp_get_max_threads() : 1);
    answers_.resize(poses_.size());
    asked_.resize(poses_.size());
    ns_.resize(rounds * poses_.size());
    last_ns_.resize(poses_.size());
  }

  // Builds the engines of all threads, and times the first.
  std::uint64_t build() {
    for (auto& engine : engines_) engine.reset();
    const auto built = [&](std::unique_ptr<Engine>& engine) { return time_ns([&] { engine.reset(new Engine(a_, b_)); }); };
    const std::uint64_t ns = built(engines_[0]);
    std::for_each(engines_.begin() + 1, engines_.end(), built);
    return ns;
  }

  std::uint64_t bytes() const { return engines_[0] ? engines_[0]->bytes() : 0; }

  std::uint64_t chunk(std::size_t begin, std::size_t end) {
    if (begin >= end || end > poses_.size()) throw std::runtime_error("no such chunk");
    if (!engines_[0]) build();
    const std::uint64_t once = std::max<std::uint64_t>(alone(begin, end), 1);
    if (once >= long_ns) {
      keep(begin, end);
      return once;
    }
    const std::uint64_t passes = once >= shortest_ns ? 1 : (shortest_ns + once - 1) / once;
    const std::uint64_t total = time_ns([&] {
      for (std::uint64_t k = 0; k < passes; ++k) pass(begin, end);
    });
    alone(begin, end);
    keep(begin, end);
    return total / passes;
  }

  void write_answers() const {
    std::vector<std::uint8_t> verdicts;
    for (const double answer : answers_)
      verdicts.push_back(mode_ == Mode::distance ? answer <= 0 : mode_ == Mode::motion ? std::isfinite(answer) : answer > 0);
    const std::string count = std::to_string(poses_.size());
    write(out_ + "/verdicts.npy", verdicts, count + ",");
    write(out_ + "/ns.npy", ns_, std::to_string(rounds_) + "," + count + ",");
    if (mode_ == Mode::all || mode_ == Mode::distance || mode_ == Mode::motion) write(out_ + "/values.npy", answers_, count + ",");
  }

 private:
  double answer(std::size_t i) {
    return mode_ == Mode::motion ? first_contact(*engines_[0], motions_[i], reach_mm_, 0) : engines_[0]->answer(mode_, poses_[i]);
  }

  // Answers the poses, in mode batch on all threads.
  void pass(std::size_t begin, std::size_t end) {
    for (auto& engine : engines_) engine->forget();
    if (mode_ != Mode::batch) {
      for (std::size_t i = begin; i < end; ++i) answers_[i] = answer(i);
      return;
    }
#pragma omp parallel for schedule(dynamic, batch_poses) num_threads(static_cast<int>(engines_.size()))
    for (std::size_t i = begin; i < end; ++i) answers_[i] = engines_[omp_get_thread_num()]->answer(Mode::first, poses_[i]);
  }

  // Answers the poses, each timed alone, or in mode batch as its share of a pass; the sum of the times.
  std::uint64_t alone(std::size_t begin, std::size_t end) {
    if (mode_ == Mode::batch) {
      const std::uint64_t ns = time_ns([&] { pass(begin, end); });
      std::fill(last_ns_.begin() + begin, last_ns_.begin() + end, ns / (end - begin));
      return ns;
    }
    std::uint64_t sum = 0;
    engines_[0]->forget();
    for (std::size_t i = begin; i < end; ++i) {
      last_ns_[i] = time_ns([&] { answers_[i] = answer(i); });
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
  std::vector<Motion> motions_;  // in mode motion one for each pose
  double reach_mm_ = 0;          // of b from its origin
  std::vector<std::unique_ptr<Engine>> engines_;  // in mode batch one for each thread
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
