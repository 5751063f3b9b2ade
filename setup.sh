#!/usr/bin/env bash
# Leaves a Debian 12 machine that has Rust able to build, run and test Lampyris. Safe to call again: what is there is kept.
# Everything that is not a Debian package goes into third-party/, which git ignores.
set -euo pipefail
cd "$(dirname "$0")"

packages=(build-essential libshaderc-dev glslang-dev spirv-tools mesa-vulkan-drivers vulkan-validationlayers libvulkan1 parallel)
minimum_rust=1.88

say() { printf 'setup: %s\n' "$*"; }
die() { printf 'setup: %s\n' "$*" >&2; exit 1; }

check_rust() {
  command -v rustc >/dev/null || die "Rust is not installed; install $minimum_rust or later from https://rustup.rs and call this again."
  local have; have=$(rustc --version | awk '{print $2}')
  [ "$(printf '%s\n%s\n' "$minimum_rust" "${have%%-*}" | sort -V | head -n 1)" = "$minimum_rust" ] \
    || die "rustc $have is too old: Lampyris needs $minimum_rust or later (rustup update)."
}

is_debian_12() {
  [ -r /etc/os-release ] && . /etc/os-release && [ "${ID:-}" = debian ] && [ "${VERSION_ID:-}" = 12 ] && command -v apt-get >/dev/null
}

install_packages() {
  local missing=() package
  for package in "${packages[@]}"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then say "Debian packages are there: ${packages[*]}"; return; fi
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || die "these packages are missing and neither root nor sudo is at hand: ${missing[*]}"
    as_root=(sudo)
  fi
  say "installing Debian packages: ${missing[*]}"
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# Debian's libshaderc_combined.a lacks glslang, so it does not link alone; merged with glslang's archives it does.
merge_shaderc() {
  local out=third-party/shaderc/libshaderc_combined.a lib; lib=/usr/lib/$(gcc -print-multiarch 2>/dev/null || echo x86_64-linux-gnu)
  if [ -s "$out" ]; then say "$out is there"; return; fi
  say "merging shaderc and glslang into $out"
  mkdir -p third-party/shaderc
  {
    echo "create $out.part"
    local name
    for name in shaderc_combined glslang SPIRV MachineIndependent GenericCodeGen OSDependent OGLCompiler HLSL SPIRV-Tools-opt SPIRV-Tools; do
      [ -r "$lib/lib$name.a" ] || die "$lib/lib$name.a is missing although its package is installed."
      echo "addlib $lib/lib$name.a"
    done
    echo save; echo end
  } | ar -M
  mv "$out.part" "$out"
}

# SwiftShader, a newer validation layer and a mock driver travel inside Debian's Chromium; only those files are kept.
unpack_chromium_drivers() {
  local out=third-party/vulkan
  if [ -s "$out/libvk_swiftshader.so" ] && [ -s "$out/mock_icd.json" ] && [ -s "$out/layers/VkLayer_khronos_validation.json" ]; then
    say "SwiftShader is there: $out"; return
  fi
  local work package; work=$(mktemp -d); trap 'rm -rf "$work"' RETURN
  chmod 755 "$work"
  for package in chromium-common chromium; do
    say "downloading Debian's $package for its SwiftShader (nothing of it is installed)"
    (cd "$work" && apt-get download -qq "$package" >/dev/null 2>&1) || continue
    dpkg-deb -x "$work/$package"_*.deb "$work/tree"
    [ -e "$work/tree/usr/lib/chromium/libvk_swiftshader.so" ] && break
  done
  local from=$work/tree/usr/lib/chromium
  if [ ! -e "$from/libvk_swiftshader.so" ]; then
    say "SwiftShader could not be had; Lampyris runs without it, the tests on the second driver do not."
    return
  fi
  mkdir -p "$out/layers"
  cp "$from/libVkICD_mock_icd.so" "$out/"
  cp "$from/libVkLayer_khronos_validation.so" "$out/layers/"
  cat >"$out/swiftshader_icd.json" <<'JSON'
{"file_format_version": "1.0.0", "ICD": {"library_path": "./libvk_swiftshader.so", "api_version": "1.3.0"}}
JSON
  cat >"$out/mock_icd.json" <<'JSON'
{"file_format_version": "1.0.0", "ICD": {"library_path": "./libVkICD_mock_icd.so", "api_version": "1.3.0"}}
JSON
  cat >"$out/layers/VkLayer_khronos_validation.json" <<'JSON'
{"file_format_version": "1.1.0", "layer": {"name": "VK_LAYER_KHRONOS_validation", "type": "GLOBAL",
 "library_path": "./libVkLayer_khronos_validation.so", "api_version": "1.3.275", "implementation_version": "1",
 "description": "Khronos validation layer", "instance_extensions": [{"name": "VK_EXT_debug_utils", "spec_version": "2"},
 {"name": "VK_EXT_validation_features", "spec_version": "6"}, {"name": "VK_EXT_layer_settings", "spec_version": "2"}]}}
JSON
  cp "$from/libvk_swiftshader.so" "$out/"
  say "SwiftShader, a validation layer and a mock driver are in $out"
}

check_rust
if is_debian_12; then
  install_packages
  command -v gcc >/dev/null || die "a C compiler is missing: apt-get install build-essential"
  merge_shaderc
  unpack_chromium_drivers
else
  say "this is not Debian 12, so nothing is changed. Wanted: a Vulkan 1.3 driver and loader, the Khronos validation layer,"
  say "and for building shaderc from source: git, cmake, ninja, python3 and a C++ compiler (Debian's names: ${packages[*]})."
fi
say "done"
