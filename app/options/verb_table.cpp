// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/verb_table.hpp"

namespace nav::app {

const std::vector<Verb>& verb_table() {
  static const std::vector<Verb> verbs{
      {"demo",
       "Show a simulated procedure: sweep, registration, needle approach with the live plane in CT",
       "demo --out DIR",
       {"sonde demo --out demo-output",
        "sonde demo --out other-patient --seed 7 --frames 10 --width 640 --height 480"}},
      {"replay",
       "Replay a recorded sweep and show its plane inside the CT",
       "replay SWEEP --ct CT --config PLUS.xml --registration FILE --out DIR",
       {"sonde replay sweep.igs.mha --ct ct.mha --registration registration.json --out replay",
        "sonde replay --session procedure.toml --window"}},
      {"live",
       "Show the live plane of the devices of a session file inside the CT",
       "live --session FILE --ct CT --registration FILE --window",
       {"sonde live --session procedure.toml --ct ct.mha --registration registration.json --window",
        "sonde live --session procedure.toml --ct ct.mha --out live --seconds 10"}},
      {"window",
       "Open the window: live devices, a recording, the simulated procedure or 3D ultrasound",
       "window [SESSION]",
       {"sonde window procedure.toml", "sonde window --simulated"}},
      {"record",
       "Record every sample of the devices of a session file",
       "record --session FILE --out MCAP",
       {"sonde record --session procedure.toml --out recording.mcap",
        "sonde record --session procedure.toml --out recording.mcap --seconds 30"}},
      {"export",
       "Write a recording of devices as a PLUS sequence",
       "export MCAP --out SWEEP",
       {"sonde export recording.mcap --out sweep.igs.mha",
        "sonde export recording.mcap --out sweep.igs.mha --config plus.xml --compress"}},
      {"serve",
       "Serve the devices of a session file by OpenIGTLink, as PLUS names them",
       "serve --session FILE",
       {"sonde serve --session procedure.toml",
        "sonde serve --session procedure.toml --port 18945 --seconds 60"}},
      {"emulate",
       "Emulate a device that shows the poses or images of a session file's devices",
       "emulate KIND --session FILE",
       {"sonde emulate ndi --session simulated.toml --line serial:/tmp/ttyNDI",
        "sonde emulate polhemus --session simulated.toml --faults 0.05 --seconds 60"}},
      {"reconstruct",
       "Make a 3D ultrasound volume of a recorded sweep",
       "reconstruct SWEEP --out VOLUME",
       {"sonde reconstruct sweep.igs.mha --out us.mha",
        "sonde reconstruct sweep.igs.mha --config plus.xml --out us.mha --method backward "
        "--compound median --fill 3 --json -"}},
      {"register",
       "Register a CT to a recorded sweep, or by landmarks, a surface or vessels",
       "register SWEEP --ct CT --config PLUS.xml --json FILE",
       {"sonde register sweep.igs.mha --ct ct.mha --landmarks points.csv --json registration.json",
        "sonde register --landmarks points.csv --json registration.json"}},
      {"info",
       "Print what a file contains: sequence, volume, registration, points, surface, …",
       "info FILE",
       {"sonde info sweep.igs.mha", "sonde info ct.mha --json -"}},
      {"slices",
       "Write CT slices: axial, coronal, sagittal, oblique, along a needle, along an image",
       "slices CT --out DIR",
       {"sonde slices ct.mha --out slices --at 10 -20 30",
        "sonde slices ct.mha --out slices --recording sweep.igs.mha --registration "
        "registration.json --fusion checkerboard"}},
      {"predicates",
       "Draw 3D ultrasound by predicates beside a standard transfer function",
       "predicates [VOLUME] --out PNG",
       {"sonde predicates --phantom carotid --out both.png",
        "sonde predicates us.mha --predicates tendon-fibres --into 0 1 0 --labels labels.mha --out "
        "both.png"}},
      {"derive",
       "Write slices of the features that predicates read from 3D ultrasound",
       "derive VOLUME --out DIR",
       {"sonde derive us.mha --out features --feature snr vesselness",
        "sonde derive us.mha --out features --into 0 1 0"}},
      {"devices",
       "List USB devices, CAN interfaces and simulated devices, or start those of a session file",
       "devices",
       {"sonde devices", "sonde devices --session procedure.toml --seconds 5 --json -"}},
      {"simulate",
       "Write a recording of a simulated patient, with its truth and its CT",
       "simulate --out SWEEP --ct CT",
       {"sonde simulate --out sweep.igs.mha --ct ct.mha",
        "sonde simulate --out sweep.igs.mha --ct ct.mha --family neck --path fan --seed 3"}}};
  return verbs;
}

const std::vector<Verb>& other_verbs() {
  static const std::vector<Verb> verbs{
      {"bench",
       "Measure run time against error (program sonde-bench)",
       "bench PART",
       {"sonde bench render --quick", "sonde bench registration --part cohort --json cohort.json"}},
      {"gallery",
       "Draw the images of docs/gallery.md (program sonde-bench)",
       "gallery --out DIR",
       {"sonde gallery --out gallery",
        "sonde gallery --out gallery --only simulator --engine reference"}},
      {"help",
       "Print the help of a verb; --man: its manual page; --tables: a page with its tables renewed",
       "help [VERB]",
       {"sonde help replay --help-all", "sonde help --man register"}},
      {"completion",
       "Print the completion of a shell: bash",
       "completion SHELL",
       {"sonde completion bash", "sonde completion bash > sonde-completion.bash"}}};
  return verbs;
}

const Verb* find_verb(std::string_view name) {
  for (const auto* verbs : {&verb_table(), &other_verbs()}) {
    for (const Verb& verb : *verbs) {
      if (verb.name == name) return &verb;
    }
  }
  return nullptr;
}

}  // namespace nav::app
