# A quick look without installing anything:
#     docker build -t signorini .
#     docker run --rm --network host signorini                                     a bundled scene in the browser, at the address it prints
#     docker run --rm -v "$PWD:/models" signorini simulate robot.xml               a model of the current folder
# The page listens on the machine's own address alone, which is why it takes the host's network.
FROM rust:1.95-slim-bookworm AS build
# meshoptimizer, which simplifies meshes for reports, is C++.
RUN apt-get update && apt-get install -y --no-install-recommends g++ && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY . .
RUN cargo install --locked --path crates/cli --root /installed --no-track

FROM debian:bookworm-slim
COPY --from=build /installed/bin/signorini /usr/local/bin/signorini
COPY LICENSE-MIT LICENSE-APACHE /usr/share/doc/signorini/
WORKDIR /models
ENTRYPOINT ["signorini"]
CMD ["view", "--port", "8080", "--no-open"]
