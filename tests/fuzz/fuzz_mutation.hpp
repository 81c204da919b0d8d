// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace nav::fuzz {

/// Changes of what a text says, beside the changes of its bytes that libFuzzer makes by itself: a
/// line or a word is removed, doubled, exchanged with another one, or replaced by a number, name or
/// sign of a list. For TOML, tables, XML, headers and command lines. Arguments and result are those
/// of LLVMFuzzerCustomMutator.
std::size_t mutate_text(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);

/// Changes of what a JSON text says: a member or element is removed, doubled, exchanged with
/// another one, or replaced by a value of another type or size. Text that is no JSON is changed by
/// its bytes.
std::size_t mutate_json(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);

}  // namespace nav::fuzz
