#!/bin/sh
# Adds the package that the Snakefile uses to the new environment; rules/common.smk sets its folder.
set -e
folder=$(python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
printf '%s\n' "${VIBRISSA_PACKAGES:?is set by the Snakefile}" >"$folder/vibrissa.pth"
