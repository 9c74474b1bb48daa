# A study in a container; docs/study.md says how. Everything is installed as in a clone, from the lock file.
FROM debian:bookworm-slim
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates git make python3 python3-venv && rm -rf /var/lib/apt/lists/*
WORKDIR /opt/vibrissa
COPY . .
RUN make setup
ENV PATH=/opt/vibrissa/.venv/bin:/usr/local/bin:/usr/bin:/bin
WORKDIR /work
CMD ["python", "-m", "vibrissa.pipeline"]
