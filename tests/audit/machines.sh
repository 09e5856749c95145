#!/usr/bin/env bash
# Try the promises of the README on bare machines, and write the table tests/audit/machines.md.
#
#   sudo bash tests/audit/machines.sh [FOLDER] [NAME ...]
#
# Needs debootstrap, for ARM64 qemu-user-static, and some 10 GB in FOLDER, /var/tmp/machines unless
# told. What is committed is tried. With names only those promises are tried, and their rows
# replaced: debian12 blas-NAME dispatch noise oldest debian13 sid plain python3.12 arm64. What is
# written by hand below the table stays.
set -euo pipefail
checkout=$(cd "$(dirname "$0")/.." && pwd)
folder=$(realpath -m "${1:-/var/tmp/machines}")
shift || true
wanted=" $* "
rows=$folder/rows
commit=$(git -C "$checkout" describe --always)
mkdir -p "$rows"

# A Debian in a folder, with what the README asks for; the package clients' settings are ours.
machine() { # NAME SUITE ARCHITECTURE
    root=$folder/$1
    if [ ! -e "$root/ready" ]; then
        local packages=python3,make,git,ca-certificates
        if [ "$3" = "$(dpkg --print-architecture)" ]; then
            debootstrap --variant=minbase --include=$packages "$2" "$root" >"$folder/$1.log"
        else
            debootstrap --arch="$3" --foreign --variant=minbase --include=$packages,python3-venv \
                "$2" "$root" >"$folder/$1.log"
            mountpoint -q /proc/sys/fs/binfmt_misc ||
                mount -t binfmt_misc none /proc/sys/fs/binfmt_misc
            update-binfmts --enable qemu-aarch64
            chroot "$root" /debootstrap/debootstrap --second-stage >>"$folder/$1.log"
        fi
        useradd --root "$root" --create-home --shell /bin/bash visitor
        touch "$root/ready"
    fi
    cp /etc/resolv.conf "$root/etc/"
    # a mirror of a suite that changes daily may be some weeks old
    echo 'Acquire::Check-Valid-Until "false";' >"$root/etc/apt/apt.conf.d/90mirror"
    mkdir -p "$root/etc/ssl/certs"
    cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
    for kind in proc sys dev dev/shm; do
        mountpoint -q "$root/$kind" || mount --rbind "/$kind" "$root/$kind"
    done
}

# Whether a promise is to be tried, and its machine to be made.
asked() { # NAME ...
    [ "$wanted" = "  " ] && return
    for name in "$@"; do [[ $wanted == *" $name "* ]] && return; done
    return 1
}

# Run a command in a fresh clone on the machine: what it printed goes to a log, a row to the table.
try() { # NAME PROMISE MACHINE USER COMMAND
    asked "$1" || return 0
    local home=$root/home/visitor/$1 log=$folder/$1.log begun=$SECONDS code=0
    rm -rf "$home"
    git clone --quiet "$checkout" "$home"
    chroot "$root" chown -R "$4" "/home/visitor/$1"
    echo "$1: $2, on $3 ..."
    chroot --userspec="$4" "$root" env -i HOME="/home/visitor" PATH=/usr/local/bin:/usr/bin:/bin \
        PIP_CERT=/etc/ssl/certs/ca-certificates.crt SSL_CERT_FILE=/etc/ssl/certs/ca-certificates.crt \
        bash -c "cd ~/$1 && $5" >"$log" 2>&1 </dev/null || code=$?
    note "$1" "$2" "$3" "$home" "$log" "$begun" "$code"
}

# Write the row of a promise that was tried; what failed is left to be looked at.
note() { # NAME PROMISE MACHINE CLONE LOG BEGUN CODE
    local home=$4 log=$5 begun=$6 code=$7 said
    said=$(grep -aoE '[0-9]+ (passed|failed|skipped)[^=]* in [0-9.]+s' "$log" | tail -1 || true)
    said="${said:-exit $code}, $(((SECONDS - begun) / 60)) min in all"
    [ $code = 0 ] || said="**fails**: $said"
    echo "| $2 | $3 | $said | $(date +%F), $commit |" >"$rows/$1"
    cat "$rows/$1"
    [ $code != 0 ] || rm -rf "$home"
}

CLEAN='git diff --exit-code --stat'
TEST='make test'

settings=(Prescott Nehalem Haswell Zen SkylakeX)
if asked debian12 dispatch noise oldest "${settings[@]/#/blas-}"; then
    machine debian12 bookworm amd64
fi
try debian12 'two commands in an ASCII locale, `git status` clean after' 'Debian 12, root' root "export LC_ALL=C PYTHONCOERCECLOCALE=0; make report && $CLEAN && $TEST"
for blas in "${settings[@]}"; do
    asked blas-$blas || continue
    if [ $blas = SkylakeX ] && ! grep -q avx512f /proc/cpuinfo; then
        echo "| the same results with OpenBLAS for $blas | Debian 12, root | not tried: this processor has no AVX-512 | $(date +%F), $commit |" >"$rows/blas-$blas"
        continue
    fi
    try blas-$blas "the same results with OpenBLAS for $blas" 'Debian 12, root' root "OPENBLAS_CORETYPE=$blas $TEST"
done
try dispatch "the same results without numpy's code for newer processors" 'Debian 12, root' root "NPY_DISABLE_CPU_FEATURES=X86_V3 $TEST"
try noise 'the same results of notebooks with sin, exp, ... off by one bit at random' 'Debian 12, root' root 'PYTHONPATH=$PWD/tests/audit/noise make test TESTS=notebooks'
try oldest 'the library with the oldest numpy and scipy it admits' 'Debian 12, root' root 'make environment && bash tests/audit/oldest.sh'

if asked debian13; then
    machine debian13 trixie amd64
    chroot "$root" sh -c 'apt-get update -qq && apt-get install -qq locales && localedef -i en_US -f ISO-8859-1 en_US' >"$folder/locale.log" 2>&1
    try debian13 'two commands on Python 3.13 in a Latin-1 locale, `git status` clean after' 'Debian 13, root' root "export LC_ALL=en_US.iso88591; make report && $CLEAN && $TEST"
fi

if asked sid; then
    machine sid sid amd64
    version=$(chroot "$root" python3 -c 'import platform; print(platform.python_version())')
    try sid "two commands on Python $version, \`git status\` clean after" "Debian sid, root" root "make report && $CLEAN && $TEST"
fi

if asked plain; then
    machine plain bookworm amd64
    chroot "$root" sh -c 'apt-get update -qq && apt-get install -qq python3-venv' >/dev/null
    try plain 'without GL and without root: all but scenes, `git status` clean after' 'Debian 12, a plain user' visitor "make report && $CLEAN && $TEST"
fi

# Python 3.12 is in no Debian: where this machine has one, it is used here.
if asked python3.12 && python=$(command -v python3.12); then
    clone=$folder/python3.12 begun=$SECONDS code=0
    rm -rf "$clone"
    git clone --quiet "$checkout" "$clone"
    env -i HOME="$HOME" PATH="$PATH" SSL_CERT_FILE=/etc/ssl/certs/ca-certificates.crt \
        bash -c "cd $clone && make PYTHON=$python test" >"$clone.log" 2>&1 </dev/null || code=$?
    note python3.12 "every test on Python $($python -c 'import platform; print(platform.python_version())')" 'this machine, root' "$clone" "$clone.log" "$begun" "$code"
fi

if asked arm64; then
    machine arm64 bookworm arm64
    try arm64 'part of the tests of the library, two notebooks' 'Debian 12 on ARM64, emulated' visitor 'make environment && bash tests/audit/arm64.sh'
fi

notes=$(sed -n '/^## /,$p' "$checkout/tests/audit/machines.md")
{
    echo '# Promises and machines'
    echo
    echo "By \`tests/audit/machines.sh\` on $(nproc) cores of$(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2). A dash: the commit wasn't noted; those rows are of several commits of that day."
    echo
    echo '| promise | machine | result | date, commit |'
    echo '| --- | --- | --- | --- |'
    cat "$rows"/*
    echo
    echo "$notes" # written by hand, kept
} >"$checkout/tests/audit/machines.md"
