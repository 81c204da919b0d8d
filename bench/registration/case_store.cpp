// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/case_store.hpp"

#include <optional>
#include <vector>

#include "bench/registration/thread_time.hpp"
#include "nav/check.hpp"

namespace nav::bench {

template <class Map, class Make>
auto CaseStore::at(Map& shelf, const typename Map::key_type& key, const Make& make) {
  typename Map::mapped_type slot;
  {
    const std::lock_guard lock(mutex_);
    auto& place = shelf[key];
    if (!place) place = std::make_shared<typename Map::mapped_type::element_type>();
    slot = place;
  }
  std::call_once(slot->once, [&] { slot->value = make(); });
  return slot->value;
}

std::shared_ptr<const Patient> CaseStore::patient(std::uint64_t seed) {
  return at(patients_, {seed, 0, 0},
            [&] { return std::make_shared<const Patient>(make_patient(seed)); });
}

std::shared_ptr<const RecordedSweep> CaseStore::sweep(std::uint64_t patient_seed, SweepPath path,
                                                      int frames) {
  const auto index = static_cast<std::uint64_t>(path);
  const auto patient = this->patient(patient_seed);
  return at(sweeps_, {patient_seed, static_cast<int>(path), frames}, [&] {
    return std::make_shared<const RecordedSweep>(
        record_sweep(*patient, {.path = path,
                                .seed = 100 * patient_seed + index,
                                .frames = frames,
                                .model = model_,
                                .level = level_}));
  });
}

std::shared_ptr<const ReadyCt> CaseStore::ready_ct(
    std::uint64_t patient_seed, const registration::ImageRegistrationOptions& options) {
  std::vector<double> steps;
  for (const auto& level : options.levels) steps.push_back(level.sample_step_mm);
  const auto patient = this->patient(patient_seed);
  return at(cts_, {patient_seed, steps}, [&] {
    std::optional<Result<registration::PreparedCt>> made;
    const double cpu_s =
        timed([&] { made = registration::PreparedCt::create(*patient->ct, options); });
    NAV_CHECK(made->has_value(), patient_seed);
    return std::make_shared<const ReadyCt>(ReadyCt{std::move(**made), cpu_s});
  });
}

void CaseStore::forget(std::uint64_t patient_seed) {
  const std::lock_guard lock(mutex_);
  const auto drop = [&](auto& shelf, auto seed_of) {
    for (auto it = shelf.begin(); it != shelf.end();) {
      it = seed_of(it->first) == patient_seed ? shelf.erase(it) : std::next(it);
    }
  };
  drop(patients_, [](const auto& key) { return std::get<0>(key); });
  drop(sweeps_, [](const auto& key) { return std::get<0>(key); });
  drop(cts_, [](const CtKey& key) { return key.first; });
}

}  // namespace nav::bench
