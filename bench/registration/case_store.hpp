// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>

#include "bench/registration/cohort.hpp"
#include "registration/prepared.hpp"

namespace nav::bench {

/// A CT ready to be registered to.
struct ReadyCt {
  registration::PreparedCt prepared;
  double cpu_s;  ///< What that took.
};

/// Patients, their CTs and sweeps: each is made once and shared by the parts of the bench, because
/// making one takes longer than registering it. Thread-safe; who asks for what is being made waits.
class CaseStore {
 public:
  /// model: how echoes of all sweeps are computed.
  explicit CaseStore(sim::AcousticModel model = sim::AcousticModel::kRays) : model_(model) {}

  std::shared_ptr<const Patient> patient(std::uint64_t seed);
  /// The sweep of a patient along a path; the same seed gives the same hand whatever the frames.
  std::shared_ptr<const RecordedSweep> sweep(std::uint64_t patient_seed, SweepPath path,
                                             int frames);
  /// For all options of the same levels' steps.
  std::shared_ptr<const ReadyCt> ready_ct(std::uint64_t patient_seed,
                                          const registration::ImageRegistrationOptions& options);
  /// Drops what belongs to a patient; those who hold it keep it.
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

  /// The value at a key, made by the first who asks.
  template <class Map, class Make>
  auto at(Map& shelf, const typename Map::key_type& key, const Make& make);

  sim::AcousticModel model_;
  std::mutex mutex_;  // Of the maps, not of what is being made.
  Shelf<Patient> patients_;
  Shelf<RecordedSweep> sweeps_;
  std::map<CtKey, std::shared_ptr<Slot<ReadyCt>>> cts_;
};

}  // namespace nav::bench
