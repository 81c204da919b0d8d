#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Boots Debian's generic kernel once in QEMU and runs a script in it.

    tests/kernel/machine.py --cache build/kernel-cache --out /tmp/out SCRIPT [ARGUMENTS]

The machine needs no image: its root folder is that of this computer, mounted read-only, and the
script runs as root in it. Only /run, /dev/shm and the folder --out, mounted at /mnt, can be written
to. It has two CAN controllers on one bus. Folders of this computer that are mounted at /run, /proc, /sys or /dev are not seen.

The kernel package is downloaded by `apt-get download` and unpacked, not installed. The exit status is
that of the script; 1 when the machine does not start or does not end in time.
"""

import argparse
import os
import pathlib
import shlex
import shutil
import subprocess
import sys

KERNEL = "linux-image-amd64"
# Folders of modules that are unpacked, below lib/modules/VERSION/kernel.
FOLDERS = ("arch/x86/crypto", "crypto", "drivers/char/hw_random", "drivers/hid", "drivers/input",
           "drivers/media", "drivers/net/can", "drivers/usb", "drivers/virtio", "fs/9p", "fs/configfs",
           "fs/fscache", "fs/netfs", "lib", "net/9p", "net/can", "net/core", "net/sched")
# Modules that are loaded before the folders of this computer can be seen. The others are loaded by
# the script: `modprobe -d "$KERNEL_MODULES" NAME`.
FIRST_MODULES = ("virtio_pci", "virtio_rng", "9pnet_virtio", "9p")
PROGRAMS = {"qemu-system-x86_64": "qemu-system-x86", "busybox": "busybox-static", "cpio": "cpio",
            "depmod": "kmod", "apt-get": "apt", "dpkg-deb": "dpkg"}
LINES_ON_FAILURE = 40

INIT = """#!/bin/busybox sh
export PATH=/bin
/bin/busybox mkdir -p /dev /proc /sys /host
/bin/busybox mount -t devtmpfs devtmpfs /dev
exec </dev/console >/dev/console 2>&1
/bin/busybox --install -s /bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
for module in $(cat /modules); do insmod "/modules.d/$module" || echo "init: cannot load $module"; done
options=trans=virtio,version=9p2000.L,msize=262144
mount -t 9p -o "$options,ro,cache=loose" root /host || { echo "init: no root folder"; poweroff -f; }
mount -t 9p -o "$options,rw" out /host/mnt || { echo "init: no folder for results"; poweroff -f; }
mount -t tmpfs tmpfs /host/run
mount -t proc proc /host/proc
mount -t sysfs sysfs /host/sys
mount -t devtmpfs devtmpfs /host/dev
mkdir -p /host/dev/pts /host/dev/shm
mount -t devpts devpts /host/dev/pts
mount -t tmpfs tmpfs /host/dev/shm
ip link set lo up
hostname sonde-kernel
chroot /host /bin/bash /mnt/job.sh
echo $? >/host/mnt/status
sync
umount /host/mnt
poweroff -f
"""


class NoMachine(Exception):
    """The machine cannot be made or booted; the text says why."""


def run(command: list, **options) -> str:
    """Standard output of a command; NoMachine when it fails."""
    try:
        done = subprocess.run(command, check=True, text=True, capture_output=True, **options)
    except subprocess.CalledProcessError as error:
        last = (error.stderr or error.stdout or "").strip().splitlines()[-3:]
        raise NoMachine(f"{shlex.join(map(str, command))} failed: {' '.join(last)}") from error
    return done.stdout


def missing_packages() -> list:
    """Packages of the programs that are not there."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    return sorted(package for program, package in PROGRAMS.items()
                  if not shutil.which(program, path=path))


def kernel_package() -> str:
    """Name of the package that holds Debian's current generic kernel."""
    for line in run(["apt-cache", "depends", KERNEL]).splitlines():
        words = line.split()
        if len(words) == 2 and words[1].startswith("linux-image-"):
            return words[1]
    raise NoMachine(f"{KERNEL}: expected a package that it depends on, found none; run apt-get update")


def unpack(package: pathlib.Path, into: pathlib.Path) -> None:
    """Unpacks the kernel and the modules of FOLDERS, and lists their dependencies."""
    members = ["./boot/vmlinuz-*", "./lib/modules/*/modules.builtin*", "./lib/modules/*/modules.order"]
    members += [f"./lib/modules/*/kernel/{folder}/*" for folder in FOLDERS]
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", package], stdout=subprocess.PIPE) as archive:
        tar = subprocess.run(["tar", "-x", "-C", into, "--wildcards", *members], stdin=archive.stdout,
                             capture_output=True, text=True)
    lost = [line for line in tar.stderr.splitlines() if "Not found" not in line and "previous errors" not in line]
    if lost or archive.returncode != 0:
        raise NoMachine(f"{package.name}: cannot be unpacked: {' '.join(lost[-3:])}")
    run(["/usr/sbin/depmod", "-b", into, version_of(into)])


def version_of(kernel: pathlib.Path) -> str:
    return next((kernel / "lib/modules").iterdir()).name


def fetch_kernel(cache: pathlib.Path) -> pathlib.Path:
    """Folder of the unpacked kernel: from the cache, or downloaded once. Without the network, a kernel
    that was downloaded before is taken."""
    cache.mkdir(parents=True, exist_ok=True)
    before = sorted(path for path in cache.glob("linux-image-*") if (path / "complete").exists())
    try:
        name = kernel_package()
        kernel = cache / name
        if (kernel / "complete").exists():
            return kernel
        fresh = cache / "download"
        shutil.rmtree(fresh, ignore_errors=True)
        (fresh / "unpacked").mkdir(parents=True)
        run(["apt-get", "-q", "download", name], cwd=fresh)
        unpack(next(fresh.glob("*.deb")), fresh / "unpacked")
        (fresh / "unpacked/complete").touch()
        shutil.rmtree(kernel, ignore_errors=True)
        (fresh / "unpacked").rename(kernel)
        shutil.rmtree(fresh)
        return kernel
    except NoMachine:
        if before:
            return before[-1]
        raise


def modules_in_order(kernel: pathlib.Path) -> list:
    """Paths of FIRST_MODULES and all that they need, each after those that it needs."""
    root = kernel / "lib/modules" / version_of(kernel)
    needs, by_name = {}, {}
    for line in (root / "modules.dep").read_text().splitlines():
        path, _, needed = line.partition(":")
        needs[path] = needed.split()
        by_name[pathlib.Path(path).name.split(".")[0].replace("-", "_")] = path
    ordered = []

    def add(path: str) -> None:
        for needed in needs[path]:
            add(needed)
        if path not in ordered:
            ordered.append(path)

    for name in FIRST_MODULES:
        if name in by_name:  # Otherwise it is part of the kernel.
            add(by_name[name])
    return [root / path for path in ordered]


def make_initramfs(kernel: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """Archive of busybox, the first modules and INIT."""
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("bin", "modules.d", "dev", "proc", "sys", "host"):
        (folder / name).mkdir(parents=True)
    shutil.copy(shutil.which("busybox"), folder / "bin/busybox")
    modules = modules_in_order(kernel)
    for module in modules:
        shutil.copy(module, folder / "modules.d")
    (folder / "modules").write_text("".join(f"{module.name}\n" for module in modules))
    (folder / "init").write_text(INIT)
    (folder / "init").chmod(0o755)
    names = "".join(f"{path.relative_to(folder)}\n" for path in sorted(folder.rglob("*")))
    archive = folder.with_suffix(".cpio")
    with open(archive, "wb") as out:
        subprocess.run(["cpio", "-o", "-H", "newc", "--quiet", "-R", "0:0"], cwd=folder, input=names.encode(),
                       stdout=out, check=True)
    return archive


def qemu_command(kernel: pathlib.Path, initramfs: pathlib.Path, out: pathlib.Path) -> list:
    # On a loaded computer the kernel mistakes the frequency of the emulated processor's counter, and its
    # clock then runs up to four times too fast. The HPET keeps the time of the computer.
    image = next((kernel / "boot").glob("vmlinuz-*"))
    arguments = ("console=ttyS0 panic=-1 quiet loglevel=4 mitigations=off nokaslr tsc=unstable clocksource=hpet audit=0 "
                 "rdinit=/init")
    return ["qemu-system-x86_64", "-nodefaults", "-no-user-config", "-no-reboot", "-display", "none",
            "-machine", "q35", "-accel", "tcg,thread=multi,tb-size=512", "-cpu", "max", "-smp", "2",
            "-m", "2048", "-kernel", image, "-initrd", initramfs, "-append", arguments,
            "-serial", "stdio", "-monitor", "none",
            "-fsdev", "local,id=root,path=/,security_model=none,readonly=on,multidevs=remap",
            "-device", "virtio-9p-pci,fsdev=root,mount_tag=root",
            "-fsdev", f"local,id=out,path={out},security_model=none",
            "-device", "virtio-9p-pci,fsdev=out,mount_tag=out",
            "-object", "can-bus,id=can", "-device", "kvaser_pci,canbus=can", "-device", "kvaser_pci,canbus=can",
            "-object", "rng-random,id=random,filename=/dev/urandom",
            "-device", "virtio-rng-pci,rng=random"]


def prepare(cache: pathlib.Path) -> pathlib.Path:
    """Folder of an unpacked kernel. NoMachine when a package or the network is missing."""
    if missing := missing_packages():
        raise NoMachine(f"expected the packages {' '.join(missing)}, found them missing; "
                        "run tools/install-dependencies.sh kernel")
    return fetch_kernel(cache)


def last_lines(out: pathlib.Path) -> str:
    """End of the console."""
    lines = (out / "console.log").read_text(errors="replace").splitlines()
    return "\n".join(lines[-LINES_ON_FAILURE:])


def boot(kernel: pathlib.Path, out: pathlib.Path, script: list, seconds: float) -> int:
    """Exit status of the script in the machine. NoMachine when there is none in time; the console is in
    out/console.log."""
    initramfs = make_initramfs(kernel, kernel.parent / "initramfs")
    out.mkdir(parents=True, exist_ok=True)
    (out / "status").unlink(missing_ok=True)
    here = {"PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/run", "TMPDIR": "/run",
            "LANG": "C.UTF-8", "KERNEL_MODULES": kernel, "OUT": "/mnt"}
    lines = [f"export {name}={shlex.quote(str(value))}\n" for name, value in here.items()]
    (out / "job.sh").write_text("".join(lines) + "exec " + shlex.join(map(str, script)) + "\n")
    with open(out / "console.log", "wb") as log, subprocess.Popen(
            list(map(str, qemu_command(kernel, initramfs, out))), stdin=subprocess.DEVNULL, stdout=log,
            stderr=subprocess.STDOUT) as machine:
        try:
            machine.wait(seconds)
        except subprocess.TimeoutExpired:
            machine.kill()
    try:
        return int((out / "status").read_text())
    except (FileNotFoundError, ValueError):
        raise NoMachine(f"the script did not end within {seconds:g} s; the console said last:\n"
                        + last_lines(out)) from None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cache", type=pathlib.Path, required=True, help="folder for the kernel")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for status and results")
    parser.add_argument("--seconds", type=float, default=300, help="time after which the machine is ended")
    parser.add_argument("script", nargs=argparse.REMAINDER, help="program of this computer, with arguments")
    options = parser.parse_args()
    try:
        return boot(prepare(options.cache.resolve()), options.out.resolve(), options.script, options.seconds)
    except NoMachine as error:
        print(f"machine: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
