// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Volumes: MetaImage, NRRD and NIfTI, as CT, as ultrasound and as labels.
#include <string_view>

#include "io/ct.hpp"
#include "io/labels.hpp"
#include "tests/fuzz/fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const bool meta = text.starts_with("ObjectType") || text.starts_with("NDims");
  const bool zipped = text.starts_with("\x1f\x8b");
  const char* name = meta                       ? "a.mha"
                     : text.starts_with("NRRD") ? "a.nrrd"
                     : zipped                   ? "a.nii.gz"
                                                : "a.nii";
  const auto file = fuzz::as_file(bytes, size, name);
  fuzz::SilentDiagnostics silent;
  const auto ct = io::read_ct(file, silent);
  if (!ct) fuzz::check_message(ct.error().message);
  const auto stored = io::read_stored_volume(file, silent);
  if (!stored) fuzz::check_message(stored.error().message);
  const auto labels = io::read_labels(file, silent);
  if (!labels) fuzz::check_message(labels.error().message);
  return 0;
}
