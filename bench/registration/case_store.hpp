// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <tuple>

#include "bench/registration/cohort.hpp"
#include "registration/prepared.hpp"

namespace nav::bench {

/// A CT prepared for registration.
struct ReadyCt {
  registration::PreparedCt prepared;
  double cpu_s;  ///< Processor time of the preparation.
};

/// Patients, their CTs and sweeps. Each is made once and shared by the parts of the benchmark,
/// because making one takes longer than registering it. Thread-safe; a caller waits for an item
/// that is being made.
class CaseStore {
 public:
  /// model: acoustic model of all sweeps. level: errors of all sweeps; absent: of the cohort.
  explicit CaseStore(sim::AcousticModel model = sim::AcousticModel::kRays,
                     std::optional<ErrorLevel> level = {})
      : model_(model), level_(level) {}

  [[nodiscard]] std::optional<ErrorLevel> level() const { return level_; }
  std::shared_ptr<const Patient> patient(std::uint64_t seed);
  /// The sweep of a patient along a path; the same seed gives the same hand motion for any number
  /// of images.
  std::shared_ptr<const RecordedSweep> sweep(std::uint64_t patient_seed, SweepPath path,
                                             int frames);
  /// One result for all options with the same sample steps of the levels.
  std::shared_ptr<const ReadyCt> ready_ct(std::uint64_t patient_seed,
                                          const registration::ImageRegistrationOptions& options);
  /// Removes the items of a patient; callers that hold them keep them.
  void forget(std::uint64_t patient_seed);

 private:
  template <class T>
  struct Slot {
    std::once_flag once;
    std::shared_ptr<const T> value;
  };
  template <class T>
  using Shelf = std::map<std::tuple<std::uint64_t, int, int>, std::shared_ptr<Slot<T>>>;
  using CtKey = std::pair<std::uint64_t, std::vector<double>>;

  /// The value at a key, made by the first caller.
  template <class Map, class Make>
  auto at(Map& shelf, const typename Map::key_type& key, const Make& make);

  sim::AcousticModel model_;
  std::optional<ErrorLevel> level_;
  std::mutex mutex_;  // Protects the maps, but not the making of items.
  Shelf<Patient> patients_;
  Shelf<RecordedSweep> sweeps_;
  std::map<CtKey, std::shared_ptr<Slot<ReadyCt>>> cts_;
};

}  // namespace nav::bench
