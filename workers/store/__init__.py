"""The store: connections, tables, migrations. Queries on the tables are in ``queries``.

==================  ====================================================================================================
``clock``           the database's clock as an SQL expression: the one clock that all processes share
``codec``           how values are stored in the database: exact floats, no pickle, no NaN in JSON
``database``        connections and transactions: SQLite and PostgreSQL behave the same behind :class:`Store`
``event_listener``  announces committed events immediately, if the database can; listeners may sleep in between
``file``            the file of an SQLite database: readable by its owner only, and the same as long as it is open
``migrate``         upgrades the schema at start, with any number of processes starting at once
``migrations``      alembic migrations of the database; applied by ``geoswarm.workers.store.migrate``
``outbox``          records, in the transaction that ends a job, whom to notify: once committed, no notification is lost
``prepared``        statements that a connection to PostgreSQL has prepared, executed by libpq
``problems``        the documents and problems of stored jobs; a process parses each once
``statements``      statements that each exchange executes: built and compiled once, and given to the driver as they are
``tables``          tables of the store
==================  ====================================================================================================
"""

from __future__ import annotations

from geoswarm.workers.store.database import Store

__all__ = ["Store"]
