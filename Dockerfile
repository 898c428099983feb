# docker run --rm -v "$PWD:/work" -v gcodesim:/cache gcodesim check part.nc --machine table_tilt
FROM python:3.12-slim
WORKDIR /src
COPY pyproject.toml README.md LICENSE ./
COPY gcodesim gcodesim
COPY machines machines
COPY samples/part.nc samples/
RUN pip install --no-cache-dir .
# Compiled kernels: a volume here spares the seconds that the first check takes to compile them.
ENV WARP_CACHE_PATH=/cache
VOLUME /cache
WORKDIR /work
ENTRYPOINT ["gcodesim"]
CMD ["--help"]
