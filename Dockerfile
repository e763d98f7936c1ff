# Filter Room in a container, with the pins of pyproject.toml and its filters compiled.
#
#   docker build -t filterroom .
#   docker run --init -p 127.0.0.1:8000:8000 -v filterroom:/data -e FILTERROOM_TOKEN=SECRET filterroom
#
# Without a token it refuses to start, because in a container it listens on all addresses.
# `python3 scripts/check-dockerfile` takes these steps on a machine without a container engine.

FROM python:3.12-slim-bookworm AS wheel
WORKDIR /build
COPY pyproject.toml README.md LICENSE ./
COPY algorithms algorithms
COPY backend backend
COPY alembic alembic
COPY frontend frontend
COPY examples/recordings examples/recordings
RUN mkdir /wheel \
    && python -c "import tomllib; pins = tomllib.load(open('pyproject.toml', 'rb'))['tool']['uv']['constraint-dependencies']; print(*pins, sep='\n')" > /wheel/pins.txt \
    && python -m pip wheel --quiet --no-deps --wheel-dir /wheel .

FROM python:3.12-slim-bookworm
ENV PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore PIP_DISABLE_PIP_VERSION_CHECK=1
COPY --from=wheel /wheel /wheel
RUN python -m pip install --quiet --constraint /wheel/pins.txt /wheel/*.whl

# Kernels compiled for one processor are of no use to another, so the image names one that nearly every x86 server of
# the last ten years is. Another one, or ARM: --build-arg NUMBA_CPU_NAME=... --build-arg NUMBA_CPU_FEATURES=... (both;
# the features are those of the building machine where they are not named). Named anew when the container is started,
# the filters are compiled again at each new container.
ARG NUMBA_CPU_NAME=x86-64-v3
ARG NUMBA_CPU_FEATURES=+avx2,+fma
ENV NUMBA_CPU_NAME=$NUMBA_CPU_NAME NUMBA_CPU_FEATURES=$NUMBA_CPU_FEATURES FILTERROOM_KERNEL_CACHE=/kernels
RUN python -c "from algorithms.warm_up import have_compiled; have_compiled()"

# numba takes compiled kernels only from a folder that it can write to.
RUN useradd --uid 10001 --user-group --no-create-home --home-dir /data --shell /usr/sbin/nologin filterroom \
    && mkdir /data \
    && chown -R filterroom:filterroom /data /kernels
USER filterroom
WORKDIR /data
VOLUME /data
ENV HOME=/data FILTERROOM_DATA_DIR=/data FILTERROOM_HOST=0.0.0.0 FILTERROOM_PORT=8000
EXPOSE 8000
HEALTHCHECK --interval=30s --timeout=5s --start-period=30s --retries=3 \
    CMD ["python", "-c", "import os, urllib.request as r; r.urlopen('http://127.0.0.1:' + os.environ['FILTERROOM_PORT'] + '/healthz', timeout=4)"]
ENTRYPOINT ["filterroom"]
CMD ["serve"]
