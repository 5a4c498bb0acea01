# docker build -t turbine_fenicsx . && docker run --rm -v "$PWD:/work" turbine_fenicsx run case.toml -o out
FROM debian:trixie-slim
SHELL ["/bin/bash", "-o", "pipefail", "-c"]
COPY . /opt/turbine_fenicsx
# scripts/setup.sh installs Debian's DOLFINx, PETSc, SLEPc and gmsh, and the rest with pip.
RUN VENV=/opt/venv /opt/turbine_fenicsx/scripts/setup.sh && rm -rf /var/lib/apt/lists/*
ENV PATH=/opt/venv/bin:$PATH OMP_NUM_THREADS=1
RUN useradd --create-home engineer
USER engineer
WORKDIR /work
ENTRYPOINT ["turbine-fenicsx"]
