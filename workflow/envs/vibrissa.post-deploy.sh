#!/bin/sh
# Lets the new environment find the package that the Snakefile uses; rules/common.smk says where it is.
set -e
folder=$(python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
printf '%s\n' "${VIBRISSA_PACKAGES:?is set by the Snakefile}" >"$folder/vibrissa.pth"
