#!/usr/bin/env bash
# Make the secrets that docker-compose.yml hands to its containers as files: passwords, the addresses that contain them,
# and the first administrator's key. A folder that holds some already is left alone.
#
#   deploy/make_secrets.sh [FOLDER]        # FOLDER: secrets, beside docker-compose.yml, unless given
set -euo pipefail

folder=${1:-"$(cd "$(dirname "$0")/.." && pwd)/secrets"}
mkdir -p "$folder"
# The folder keeps other users out. The files in it can be read, because the users inside the containers must: Docker
# hands a file over with the owner and the mode that it has.
chmod 700 "$folder"

if [ -e "$folder/database_url" ] || [ -e "$folder/postgres_password" ] || [ -e "$folder/redis.conf" ] ||
    [ -e "$folder/broker_url" ] || [ -e "$folder/api_key" ]; then
    echo "geoswarm: $folder holds secrets already; they are left as they are" >&2
    exit 1
fi

random() { od -An -N24 -tx1 /dev/urandom | tr -d ' \n'; }
write() { # FILE TEXT
    printf '%s\n' "$2" >"$folder/$1"
    chmod 444 "$folder/$1"
}

postgres=$(random)
redis=$(random)
write postgres_password "$postgres"
write database_url "postgresql://geoswarm:$postgres@postgres:5432/geoswarm"
write redis.conf "requirepass $redis"
write broker_url "redis://:$redis@redis:6379/0"
write api_key "$(random)"
echo "geoswarm: five secrets are in $folder; the service's first API key is in $folder/api_key"
